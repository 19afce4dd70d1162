#include "experiments/render/volume_actor.h"

#include <vtkColorTransferFunction.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkRenderer.h>
#include <vtkUnsignedShortArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

namespace voxcarve {

namespace {

constexpr double kSamplesAVoxel = 4;  ///< along a ray
/// The opacity that a voxel's length of full density has: what lies a sample or two below the surface is hidden.
constexpr double kFullOpacity = 0.9999;
constexpr double kAmbient = 0.2;  ///< light as of meshes
constexpr double kSpecular = 0.06;
constexpr double kSpecularPower = 20;

}  // namespace

void add_volume(vtkRenderer& renderer, const DisplayVolume& volume) {
  const vtkNew<vtkUnsignedShortArray> samples;
  // VTK only reads them, though its interface does not say so.
  samples->SetArray(const_cast<std::uint16_t*>(volume.samples.data()), static_cast<vtkIdType>(volume.samples.size()),
                    1);
  const vtkNew<vtkImageData> image;
  image->SetDimensions(static_cast<int>(volume.dims[0]), static_cast<int>(volume.dims[1]),
                       static_cast<int>(volume.dims[2]));
  image->SetOrigin(volume.first_sample.data());
  image->SetSpacing(volume.spacing, volume.spacing, volume.spacing);
  image->GetPointData()->SetScalars(samples);

  const vtkNew<vtkFixedPointVolumeRayCastMapper> mapper;
  mapper->SetInputData(image);
  mapper->SetBlendModeToComposite();
  // Fixed, not chosen by the time that frames take: else the pixels would depend on the machine's load.
  mapper->AutoAdjustSampleDistancesOff();
  mapper->SetImageSampleDistance(1);
  mapper->SetSampleDistance(static_cast<float>(volume.spacing / kSamplesAVoxel));
  mapper->SetInteractiveSampleDistance(static_cast<float>(volume.spacing / kSamplesAVoxel));

  const vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(volume.opaque - volume.band, 0);
  opacity->AddPoint(volume.opaque, kFullOpacity);
  const vtkNew<vtkColorTransferFunction> color;
  color->AddRGBPoint(0, kNeutralColor[0] / 255.0, kNeutralColor[1] / 255.0, kNeutralColor[2] / 255.0);

  const vtkNew<vtkVolume> actor;
  actor->SetMapper(mapper);
  vtkVolumeProperty& look = *actor->GetProperty();
  look.SetColor(color);
  look.SetScalarOpacity(opacity);
  look.SetScalarOpacityUnitDistance(volume.spacing);
  look.SetInterpolationTypeToLinear();
  look.ShadeOn();
  look.SetAmbient(kAmbient);
  look.SetDiffuse(1 - kAmbient);
  look.SetSpecular(kSpecular);
  look.SetSpecularPower(kSpecularPower);
  renderer.AddVolume(actor);
}

}  // namespace voxcarve
