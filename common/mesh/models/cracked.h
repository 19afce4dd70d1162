// The degeneracies of [NT03, Table 1], each alone on a solid of known volume, genus and components.
#pragma once

#include <string>
#include <vector>

namespace voxcarve {

/// A procedural model "cracked-..." and the solid that a repair of it should give. With the parameter intact=on the
/// model is that solid's surface: closed manifolds that do not intersect.
struct CrackedSolid {
  std::string name;        ///< of the procedural model
  std::string degeneracy;  ///< in the words of the paper
  double volume = 0;       ///< in cubed model units, exact
  int genus = 0;           ///< sum over the components
  int components = 0;      ///< of the interior: parts that touch in a point alone are two
};

/// All of them, in alphabetical order.
const std::vector<CrackedSolid>& cracked_solids();

}  // namespace voxcarve
