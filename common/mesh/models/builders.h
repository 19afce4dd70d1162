// What the files of this folder share: each model's entry of the registry, the limit on a model's size, and where its
// front is.
#pragma once

#include <Eigen/Geometry>
#include <string_view>
#include <vector>

#include "common/mesh/models/procedural.h"

namespace voxcarve {

ProceduralModel blade_model();
ProceduralModel bolt_model();
ProceduralModel chair_model();
/// All "cracked-...": see cracked.h.
std::vector<ProceduralModel> cracked_models();
ProceduralModel elm_model();
ProceduralModel engine_model();
ProceduralModel foot_bones_model();
ProceduralModel genus_n_model();
ProceduralModel geospheres_model();
ProceduralModel interpenetrating_figure_model();
ProceduralModel mechanical_part_model();
ProceduralModel mushrooms_model();
ProceduralModel perforated_box_model();
ProceduralModel pine_model();
ProceduralModel sconce_model();
ProceduralModel sphereflake_model();
ProceduralModel torso_ribs_model();
ProceduralModel torus_model();
ProceduralModel two_spheres_model();
ProceduralModel yucca_model();

/// Throws ParameterError when `triangles`, multiplied out from the parameters of `model` before anything is built,
/// exceeds 20 million. A double, so that no product of parameters overflows.
void require_triangles_within_limit(std::string_view model, double triangles);

/// The parameter "form", mesh or implicit, of a model that has a `solid` as well.
ParameterSpec form_parameter();

/// Half a turn about z, for what was built with its front at higher y: the front of a model is at its lower y.
inline Eigen::Affine3d facing_front() {
  return Eigen::Affine3d(Eigen::Scaling(-1.0, -1.0, 1.0));
}

}  // namespace voxcarve
