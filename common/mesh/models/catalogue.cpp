#include "common/mesh/models/catalogue.h"

#include <algorithm>
#include <system_error>

#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

std::string_view to_string(ExternalKind kind) {
  return kind == ExternalKind::kMesh ? "mesh" : "volume";
}

const std::vector<ExternalModel>& external_models() {
  static const std::vector<ExternalModel> models = {
      {"airboat", "airboat.obj", "KJ seat and assembly", "github.com/amanshenoy/mesh-viewer: data/airboat.obj",
       "MIT (repo); model looks like a Viewpoint mesh, origin not stated",
       "5c417a63c5bf939be8c8d9fb7d8692e5c8fe2be32ba2556a7f89c37dab08165e", ExternalKind::kMesh},
      {"aircraft_304", "aircraft_304.off", "KJ upper deck (324 triangles), in size only",
       "github.com/MEPP-team/MEPP2: Testing/Data/aircraft.off", "LGPL-3.0 (repo)",
       "07b675862ebd2bac4145a9ec5908372994744569d6fca52a1a67235496ae06ba", ExternalKind::kMesh},
      {"al_capone", "al_capone.obj", "NT Fig. 7", "github.com/kmammou/v-hacd: app/meshes/al.obj",
       "repo BSD-3-Clause, but file header says Copyright 1996 Viewpoint Datalabs",
       "fb15e3e01e369f610eec865796e40d92de5c52ef81db72544d1708878f89eb9f", ExternalKind::kMesh},
      {"buddha_100k", "buddha_100k.obj", "WR Buddha", "github.com/nwtnni/photon: models/buddha.obj",
       "MIT (repo); model is a decimated Stanford scan",
       "1b2479c77154f90c31281cb69ff1963dcd2ceb52d9803555eb70a2a1a09111de", ExternalKind::kMesh},
      {"bunny_base_holes", "bunny_base_holes.ply", "NT and WR bunny, with the holes in its base",
       "github.com/pyvista/vtk-data: Data/bunny.ply",
       "Apache-2.0 (repo LICENSE; VTKData part BSD-3); Stanford 3D Scanning Repository terms apply",
       "442bdd8f35bf107005424bbd60100358cd57fa4711640766a5802a17d58f98ad", ExternalKind::kMesh},
      {"chair_gothic", "chair_gothic.obj", "NT Fig. 9", "github.com/kmammou/v-hacd: app/meshes/ob_chair_gothic.obj",
       "repo BSD-3-Clause; mesh origin not stated", "1df8070d7cef2c60128e37b5eda281cabcff09da6d4a5a1f14b88f513d6acb6f",
       ExternalKind::kMesh},
      {"chair_slatted_wood", "chair_slatted_wood.obj", "NT Fig. 9",
       "github.com/kmammou/v-hacd: app/meshes/ob_chair_wood.obj", "repo BSD-3-Clause; mesh origin not stated",
       "4183e31e92fd42fcbbd9cd016862f358f62f8d5497a4ea8bdfc1a8acd22841f9", ExternalKind::kMesh},
      {"csg_featuretype", "csg_featuretype.ply", "He Fig. 4", "github.com/mikedh/trimesh: models/featuretype.ply",
       "MIT (repo); model origin not stated", "765b5771a7b13232ba3bea3bc89e0b8a477cb69ac4a9c1791bde0c700787ffc5",
       ExternalKind::kMesh},
      {"csg_plate_holes", "csg_plate_holes.stl", "He Fig. 4", "github.com/mikedh/trimesh: models/plate_holes.STL",
       "MIT (repo); model origin not stated", "318f92206dd20b2cede5b70eb5e686d3627c6b157b91e9ed383314329dcff209",
       ExternalKind::kMesh},
      {"cycloidal_drive_coloured", "cycloidal_drive_coloured.ply", "NT Fig. 8, as a coloured assembly of many parts",
       "github.com/mikedh/trimesh: models/cycloidal.ply", "MIT (repo); model origin not stated",
       "d10f336ff4c4ca7f2c262b1fd880a2ac2bbe1ea60c072951f3f5003986481e5a", ExternalKind::kMesh},
      {"dragon_100k", "dragon_100k.obj", "WR scanned models", "github.com/nwtnni/photon: models/dragon.obj",
       "MIT (repo); model is a decimated Stanford scan",
       "cab43170b1a682b21817805bd02ee96e4e958efc68d1716f0d82b4c7a255e3fb", ExternalKind::kMesh},
      {"foot_bones", "foot_bones.ply", "HE foot bones", "github.com/pyvista/vtk-data: Data/fsu/footbones.ply",
       "Apache-2.0 (repo LICENSE; VTKData part BSD-3)",
       "9f5112422a4f73c3d7b4bc94741798c5ef732d9249d05d56282d0eb744c0c1bb", ExternalKind::kMesh},
      {"horse_97k", "horse_97k.ply", "HE horse (19,851 vertices)", "github.com/pyvista/vtk-data: Data/horse.ply",
       "Apache-2.0 (repo LICENSE; VTKData part BSD-3)",
       "dfadaea01775943a75f9bf0560e6ad55aab39694af3003d9976a46e58226c4d7", ExternalKind::kMesh},
      {"interpenetrating_three_cubes", "interpenetrating_three_cubes.stl", "NT interpenetrating parts",
       "github.com/gcherchi/FastAndRobustMeshArrangements: data/three_cubes.stl", "MIT (repo)",
       "38b6733667538935a7008d74b9419df12e1eb96ef651d451cfb2c8584d220a60", ExternalKind::kMesh},
      {"interpenetrating_two_spheres", "interpenetrating_two_spheres.stl", "NT interpenetrating parts",
       "github.com/gcherchi/FastAndRobustMeshArrangements: data/two_spheres.stl", "MIT (repo)",
       "ba4ded66f48d65635b1b1975afe5ebc8bf9d315ded194056eb2a2ba469ac6fe4", ExternalKind::kMesh},
      {"lamp", "lamp.obj", "HE sconce", "github.com/kmammou/v-hacd: app/meshes/lamp.obj",
       "repo BSD-3-Clause, but file header says Copyright 1996 Viewpoint Datalabs",
       "81a0e24c8590cde20330ae3f02bf03b2c2695cdd77319a8ef28b7f9a52172bb3", ExternalKind::kMesh},
      {"motor", "motor.obj", "NT Fig. 8", "github.com/pyvista/vtk-data: Data/motor.g, converted from Movie.BYU to OBJ",
       "Apache-2.0 (repo LICENSE; VTKData part BSD-3)",
       "26e888e075cae86a7c0dd634ce832f23336981737f88a2b36f37fedc708b7169", ExternalKind::kMesh},
      {"mushroom", "mushroom.off", "HE mushrooms (one of several)",
       "github.com/MEPP-team/MEPP2: Testing/Data/mushroom.off", "LGPL-3.0 (repo)",
       "14362b19fa47b1f4bb88a77bd78fa73ddf1f4b0ad37ad2f3a2f41cd3195cebe3", ExternalKind::kMesh},
      {"office_chair", "office_chair.obj", "NT Fig. 9, KJ aircraft seat",
       "github.com/cnr-isti-vclab/meshlab: sample/office_chair.obj", "GPL-3.0 (repo)",
       "eb036c46431fd48768dc7cb3441bcc7c67c3548cbe8bab4a3f4ac42b35d928c7", ExternalKind::kMesh},
      {"torso", "torso.ply", "HE torso (skin)",
       "github.com/pyvista/vtk-data: Data/Torso.vtp, converted from VTP to PLY",
       "Apache-2.0 (repo LICENSE; VTKData part BSD-3)",
       "13a1c613fb2abc960a853c5d56f9ccb919c7e44841ccbc2243c4d32cdef67eda", ExternalKind::kMesh},
      {"truss_beam", "truss_beam.obj", "slatted parts with many tunnels",
       "github.com/rarora7777/VolumetricTruss: results/beam_solid.obj", "MIT (repo)",
       "1c6a12bef6e80c7b564942e0cc279cb0452c457c571278813fbfaeae007146cb", ExternalKind::kMesh},
      {"turbine_blade", "turbine_blade.ply", "NT turbine blade", "github.com/pyvista/vtk-data: Data/turbineblade.ply",
       "Apache-2.0 (repo LICENSE; VTKData part BSD-3)",
       "c2850452c86e3076e0d70f77859bee942c096153f687c66b85549f3e52d809cb", ExternalKind::kMesh},
      {"bolt_70x123x66", "bolt_70x123x66.nrrd", "He bolt",
       "github.com/pyvista/vtk-data: Data/bolt.slc, decoded to NRRD", "Apache-2.0 (repo LICENSE; VTKData part BSD-3)",
       "e451044943c294a34dc6716e5b109d1c6e05f5c47ee06a2e0d66711d3f57e09b", ExternalKind::kVolume},
      {"ct_head_256x256x113", "ct_head_256x256x113.nrrd", "He CT head (256 x 256 x 225)",
       "github.com/yangrc1234/UnityIsoSurfaceVolumeRenderer: CThead/CThead.1..113, slices joined in one NRRD",
       "unknown (Stanford volume data archive CThead)",
       "6a0668c24af8bebf23a729a5b9ecb7fdeb2d61deb31361a427464b60d520a8ea", ExternalKind::kVolume},
      {"ct_headsq_64x64x93", "ct_headsq_64x64x93.nrrd", "He CT head, small",
       "github.com/pyvista/vtk-data: Data/headsq/quarter.1..93, slices joined in one NRRD",
       "Apache-2.0 (repo LICENSE; VTKData part BSD-3)",
       "4493f5092373d839f937c56825d4cbbb963a55020ad875675348e29d5a1d3681", ExternalKind::kVolume},
      {"nut_68x41x59", "nut_68x41x59.nrrd", "companion of the He bolt",
       "github.com/pyvista/vtk-data: Data/nut.slc, decoded to NRRD", "Apache-2.0 (repo LICENSE; VTKData part BSD-3)",
       "1ba44c27a146ae90ba61528acc5848f2b56e77e5e5bb9729c29931c201486b8f", ExternalKind::kVolume}};
  return models;
}

namespace {

const ExternalModel& external_model(std::string_view name) {
  std::vector<std::string> names;
  for (const ExternalModel& model : external_models()) {
    if (model.name == name) return model;
    names.push_back(model.name);
  }
  throw ParameterError("no external model is called '" + std::string(name) + "'" + suggestion(name, names));
}

}  // namespace

std::filesystem::path find_external(std::string_view name, const std::filesystem::path& data_folder) {
  const ExternalModel& model = external_model(name);
  const std::string start = "external model '" + model.name + "': ";
  const std::string remedy = "; put " + model.file + " there (from " + model.source + ")";
  if (data_folder.empty()) {
    throw InputError(start + "no data folder; set VOXCARVE_DATA or --data to a folder that holds " + model.file +
                     " (from " + model.source + ")");
  }
  std::error_code ignored;  // what cannot be looked at is as good as missing
  if (!std::filesystem::is_directory(data_folder, ignored)) {
    throw InputError(start + data_folder.string() + " is not a folder" + remedy);
  }
  std::filesystem::path path = data_folder / model.file;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw InputError(start + "there is no " + path.string() + remedy);
  }
  return path;
}

}  // namespace voxcarve
