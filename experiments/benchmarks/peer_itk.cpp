// ITK 5: opening by thresholds of two distance maps, the distance map alone, labelling, and the recursive Gaussian.
#include <itkBinaryThresholdImageFilter.h>
#include <itkConnectedComponentImageFilter.h>
#include <itkImage.h>
#include <itkMultiThreaderBase.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>
#include <itkSmoothingRecursiveGaussianImageFilter.h>

#include <algorithm>

#include "experiments/benchmarks/peers.h"

namespace voxcarve::bench {

namespace {

using Mask = itk::Image<std::uint8_t, 3>;
using Distances = itk::Image<float, 3>;  // the filter takes floating point only; exact in squares up to 2^24
using Labels = itk::Image<std::int32_t, 3>;
using Field = itk::Image<float, 3>;
using DistanceMap = itk::SignedMaurerDistanceMapImageFilter<Mask, Distances>;
using Threshold = itk::BinaryThresholdImageFilter<Distances, Mask>;

/// The grid's own memory as an image; ITK only reads it.
template <class Pixel>
typename itk::Image<Pixel, 3>::Pointer as_image(const Grid<Pixel>& grid) {
  using Image = itk::Image<Pixel, 3>;
  typename Image::SizeType size;
  for (unsigned axis = 0; axis < 3; ++axis)
    size[axis] = static_cast<itk::SizeValueType>(grid.frame.dims[static_cast<Eigen::Index>(axis)]);
  typename Image::Pointer image = Image::New();
  image->SetRegions(typename Image::RegionType(size));
  constexpr bool kOwned = false;
  image->GetPixelContainer()->SetImportPointer(const_cast<Pixel*>(grid.values.data()), grid.values.size(), kOwned);
  return image;
}

/// For filters made from now on; into how many pieces each cuts its work is left to ITK.
void use_threads(int threads) {
  const auto count = static_cast<itk::ThreadIdType>(threads);
  itk::MultiThreaderBase::SetGlobalMaximumNumberOfThreads(count);
  itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(count);
}

/// Squared distances from the voxels that are `background` to the others, negative in these.
DistanceMap::Pointer distance_map(std::uint8_t background) {
  DistanceMap::Pointer map = DistanceMap::New();
  map->SetBackgroundValue(background);
  map->SquaredDistanceOn();
  map->UseImageSpacingOff();
  map->ReleaseDataFlagOn();
  return map;
}

Threshold::Pointer threshold(DistanceMap* map, float upper, std::uint8_t inside) {
  Threshold::Pointer filter = Threshold::New();
  filter->SetInput(map->GetOutput());
  filter->SetUpperThreshold(upper);
  filter->SetInsideValue(inside);
  filter->SetOutsideValue(static_cast<std::uint8_t>(1 - inside));
  filter->ReleaseDataFlagOn();
  return filter;
}

}  // namespace

FilteringPeer itk_opening(const BinaryVolume& volume, std::int64_t radius, int threads) {
  return [&volume, radius, threads] {
    use_threads(threads);
    const auto reach = static_cast<float>(radius * radius);
    // What is no further than the radius from the exterior goes, then what is no further from the rest comes back.
    const DistanceMap::Pointer to_exterior = distance_map(1);
    to_exterior->SetInput(as_image(volume));
    const Threshold::Pointer eroded = threshold(to_exterior, reach, 0);
    const DistanceMap::Pointer to_eroded = distance_map(0);
    to_eroded->SetInput(eroded->GetOutput());
    const Threshold::Pointer opened = threshold(to_eroded, reach, 1);
    const auto made = timed([&] {
      opened->Update();
      return Mask::Pointer(opened->GetOutput());
    });
    Timed<BinaryVolume> result{made.seconds, BinaryVolume::uninitialized(volume.frame)};
    std::copy_n(made.result->GetBufferPointer(), volume.values.size(), result.result.values.begin());
    return result;
  };
}

DistancePeer itk_squared_distance(const BinaryVolume& volume, int threads) {
  return [&volume, threads] {
    use_threads(threads);
    const DistanceMap::Pointer map = distance_map(0);
    map->SetInput(as_image(volume));
    const auto made = timed([&] {
      map->Update();
      return Distances::Pointer(map->GetOutput());
    });
    Timed<Grid<std::int32_t>> result{made.seconds, Grid<std::int32_t>::uninitialized(volume.frame)};
    std::transform(made.result->GetBufferPointer(), made.result->GetBufferPointer() + volume.values.size(),
                   result.result.values.begin(), [](float squared) { return static_cast<std::int32_t>(squared); });
    return result;
  };
}

CountingPeer itk_labelling(const BinaryVolume& volume, int threads) {
  return [&volume, threads] {
    use_threads(threads);
    const auto filter = itk::ConnectedComponentImageFilter<Mask, Labels>::New();
    filter->SetInput(as_image(volume));
    filter->FullyConnectedOff();
    const auto made = timed([&] {
      filter->Update();
      return Labels::Pointer(filter->GetOutput());
    });
    return Timed<std::int64_t>{made.seconds, static_cast<std::int64_t>(filter->GetObjectCount())};
  };
}

FieldPeer itk_gaussian(const Grid<float>& field, double sigma, int threads) {
  return [&field, sigma, threads] {
    use_threads(threads);
    const auto filter = itk::SmoothingRecursiveGaussianImageFilter<Field, Field>::New();
    filter->SetInput(as_image(field));
    filter->InPlaceOff();
    filter->SetSigma(sigma);
    const auto made = timed([&] {
      filter->Update();
      return Field::Pointer(filter->GetOutput());
    });
    Timed<Grid<float>> result{made.seconds, Grid<float>::uninitialized(field.frame)};
    std::copy_n(made.result->GetBufferPointer(), field.values.size(), result.result.values.begin());
    return result;
  };
}

}  // namespace voxcarve::bench
