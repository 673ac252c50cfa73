# Finds the LIGGGHTS library and headers; defines the imported target LIGGGHTS::liggghts.
#
#   LIGGGHTS_ROOT      prefix, or a LIGGGHTS source tree with a library built in its src/
#
# Debian: libliggghts-dev (headers in /usr/include/liggghts).

find_path(LIGGGHTS_INCLUDE_DIR lammps.h
  HINTS ${LIGGGHTS_ROOT} PATH_SUFFIXES include/liggghts liggghts src)
find_library(LIGGGHTS_LIBRARY NAMES liggghts HINTS ${LIGGGHTS_ROOT} PATH_SUFFIXES lib src)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(LIGGGHTS
  REQUIRED_VARS LIGGGHTS_LIBRARY LIGGGHTS_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "Install libliggghts-dev, or pass -DLIGGGHTS_ROOT=<prefix or source tree>.")

if(LIGGGHTS_FOUND AND NOT TARGET LIGGGHTS::liggghts)
  add_library(LIGGGHTS::liggghts UNKNOWN IMPORTED)
  set_target_properties(LIGGGHTS::liggghts PROPERTIES
    IMPORTED_LOCATION "${LIGGGHTS_LIBRARY}"
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${LIGGGHTS_INCLUDE_DIR}"
    INTERFACE_INCLUDE_DIRECTORIES "${LIGGGHTS_INCLUDE_DIR}")
endif()
mark_as_advanced(LIGGGHTS_INCLUDE_DIR LIGGGHTS_LIBRARY)
