# How every target of the project is compiled.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

# Not -O3: g++ 12 then warns of std::string's own concatenation (GCC bug 105651), and warnings are errors here.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
if(VOXCARVE_SANITIZE)
  # Lines in reports, and no more: CGAL's templates with sanitizers and full debugging data take minutes and gigabytes.
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g1 -DNDEBUG")
endif()

find_program(VOXCARVE_CCACHE ccache)
if(VOXCARVE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Precompiled headers carry time stamps that ccache must be told to look past.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
      CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime CCACHE_PCH_EXTSUM=1 ${VOXCARVE_CCACHE})
endif()

# CGAL and Eigen translation units take up to 1.7 GB each: no more of them at once than memory allows.
cmake_host_system_information(RESULT VOXCARVE_MEMORY_MB QUERY TOTAL_PHYSICAL_MEMORY)
math(EXPR VOXCARVE_HEAVY_JOBS "${VOXCARVE_MEMORY_MB} / 2500 + 1")
set_property(GLOBAL APPEND PROPERTY JOB_POOLS heavy=${VOXCARVE_HEAVY_JOBS})

# Settings of our own code. Third-party includes are system includes, so their warnings stay theirs.
add_library(voxcarve_options INTERFACE)
target_include_directories(voxcarve_options INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(voxcarve_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror
  # The same bytes everywhere: no fused multiply-add that one machine has and another lacks.
  -ffp-contract=off)
if(VOXCARVE_SANITIZE)
  target_compile_options(voxcarve_options INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
    -Wno-maybe-uninitialized)  # the checks themselves look uninitialised to g++
  target_link_options(voxcarve_options INTERFACE -fsanitize=address,undefined)
endif()

# voxcarve_library(NAME SOURCES a.cpp ... LINKS target ... [PRIVATE_LINKS target ...])
#
# One target a folder. PRIVATE_LINKS are third-party libraries that appear in .cpp files only.
function(voxcarve_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC voxcarve_options Eigen3::Eigen ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS})
  target_precompile_headers(${name} PRIVATE <Eigen/Core> <Eigen/Geometry> <algorithm> <array> <cstdint> <string> <vector>)
endfunction()

# voxcarve_method(FOLDER): a method's folder, linked into the registry.
macro(voxcarve_method folder)
  add_subdirectory(${folder})
  target_link_libraries(voxcarve_methods PRIVATE voxcarve_method_${folder})
endmacro()
