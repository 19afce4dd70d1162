// Densities from several samples a voxel: kernels of integer weights over volumes of bits.
#pragma once

#include <cstdint>
#include <span>

#include "common/run/context.h"
#include "common/volume/bit_volume.h"
#include "common/volume/grid.h"
#include "common/volume/voxelize.h"

namespace voxcarve {

/// A separable kernel. Along each axis voxel i is the weighted sum of the samples samples * i + offset onward, counted
/// from the first sample of `sample_frame`; its density is the sum over all three axes over the third power of `total`.
///
/// The Gaussian's weights are 2^10 times its values at the samples' offsets, normalised and rounded; the middle one
/// takes what is missing of 2^10. No set of samples has a density that differs by 0.005 from that of real weights.
struct SampleKernel {
  int samples = 1;
  int reach = 0;  ///< voxels of margin around a grid of densities that samples are taken from
  int offset = 0;
  std::span<const std::uint16_t> weights;  ///< symmetric
  std::uint32_t total = 1;                 ///< of the weights; its third power fits 32 bits
};

/// Throws ParameterError for a number of samples that is not 1, 2 or 3.
SampleKernel sample_kernel(const SupersamplingOptions& options);

/// The grid of the densities of `frame`: for a kernel that reaches beyond a voxel it is padded by 2 voxels.
GridFrame density_frame(const GridFrame& frame, const SampleKernel& kernel);

/// The grid of the samples: the voxels of density_frame and those in reach of them, each divided into samples^3.
GridFrame sample_frame(const GridFrame& frame, const SampleKernel& kernel);

/// The densities of `frame`, on density_frame, from samples on sample_frame.
DensityVolume filtered(const BitVolume& samples, const GridFrame& frame, const SampleKernel& kernel,
                       RunContext& context);

}  // namespace voxcarve
