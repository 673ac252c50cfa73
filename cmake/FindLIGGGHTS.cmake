# Finds the LIGGGHTS library and headers; defines the imported target LIGGGHTS::liggghts.
#
#   LIGGGHTS_ROOT      prefix, or a LIGGGHTS source tree with a shared library built in its src/;
#                      nothing is searched elsewhere
#
# Debian: libliggghts-dev (headers in /usr/include/liggghts). Needs MPI, which is found before.

if(DEFINED LIGGGHTS_SEARCHED AND NOT LIGGGHTS_SEARCHED STREQUAL LIGGGHTS_ROOT)
  # What was found elsewhere is in the cache.
  unset(LIGGGHTS_INCLUDE_DIR CACHE)
  unset(LIGGGHTS_LIBRARY CACHE)
endif()
set(LIGGGHTS_SEARCHED "${LIGGGHTS_ROOT}" CACHE INTERNAL "")
if(LIGGGHTS_ROOT)
  # Headers of one LIGGGHTS with the library of another make a program that crashes.
  set(search PATHS "${LIGGGHTS_ROOT}" NO_DEFAULT_PATH)
else()
  set(search "")
endif()
find_path(LIGGGHTS_INCLUDE_DIR lammps.h ${search}
  PATH_SUFFIXES src include/liggghts include liggghts)
find_library(LIGGGHTS_LIBRARY NAMES liggghts ${search}
  PATH_SUFFIXES src lib "lib/${CMAKE_LIBRARY_ARCHITECTURE}")

set(problem "Install libliggghts-dev, or pass -DLIGGGHTS_ROOT=<prefix or source tree>.")
if(LIGGGHTS_ROOT AND NOT LIGGGHTS_INCLUDE_DIR)
  string(CONCAT problem "LIGGGHTS_ROOT=${LIGGGHTS_ROOT} has no src/lammps.h, include/lammps.h or "
    "include/liggghts/lammps.h: pass a prefix or a source tree.")
elseif(LIGGGHTS_ROOT AND NOT LIGGGHTS_LIBRARY)
  string(CONCAT problem "LIGGGHTS_ROOT=${LIGGGHTS_ROOT} has headers and no libliggghts.so in src or "
    "lib: build the shared library (docs/developers/build.md).")
endif()

if(LIGGGHTS_INCLUDE_DIR AND LIGGGHTS_LIBRARY)
  # The layout of contacts in the headers depends on this option.
  file(STRINGS "${LIGGGHTS_LIBRARY}" superquadric LIMIT_COUNT 1 REGEX "AtomVecSuperquadric")
  if(superquadric)
    set(LIGGGHTS_FITS FALSE)
    string(CONCAT problem "${LIGGGHTS_LIBRARY} was built with superquadric particles: build it with "
      "USE_SUPERQUADRICS = \"OFF\" (docs/developers/build.md).")
  else()
    include(CheckCXXSourceCompiles)
    set(CMAKE_REQUIRED_INCLUDES "${LIGGGHTS_INCLUDE_DIR}")
    set(CMAKE_REQUIRED_LIBRARIES "${LIGGGHTS_LIBRARY}" MPI::MPI_CXX)
    set(CMAKE_REQUIRED_QUIET ON)
    # Checked each time: the library may have been built again.
    unset(LIGGGHTS_FITS CACHE)
    check_cxx_source_compiles("#include <mpi.h>
      #include \"lammps.h\"
      int main() { return new LAMMPS_NS::LAMMPS(0, nullptr, MPI_COMM_WORLD) == nullptr; }"
      LIGGGHTS_FITS)
    unset(CMAKE_REQUIRED_INCLUDES)
    unset(CMAKE_REQUIRED_LIBRARIES)
    unset(CMAKE_REQUIRED_QUIET)
    if(NOT LIGGGHTS_FITS)
      string(CONCAT problem "A program with ${LIGGGHTS_LIBRARY} does not link. Was it built with the "
        "MPI of ${MPI_CXX_COMPILER}? See ${CMAKE_BINARY_DIR}/CMakeFiles/CMakeError.log.")
    endif()
  endif()
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(LIGGGHTS
  REQUIRED_VARS LIGGGHTS_LIBRARY LIGGGHTS_INCLUDE_DIR LIGGGHTS_FITS
  REASON_FAILURE_MESSAGE "${problem}")

if(LIGGGHTS_FOUND AND NOT TARGET LIGGGHTS::liggghts)
  add_library(LIGGGHTS::liggghts UNKNOWN IMPORTED)
  set_target_properties(LIGGGHTS::liggghts PROPERTIES
    IMPORTED_LOCATION "${LIGGGHTS_LIBRARY}"
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${LIGGGHTS_INCLUDE_DIR}"
    INTERFACE_INCLUDE_DIRECTORIES "${LIGGGHTS_INCLUDE_DIR}")
endif()
mark_as_advanced(LIGGGHTS_INCLUDE_DIR LIGGGHTS_LIBRARY)
