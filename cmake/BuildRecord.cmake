# build.json: with what the compiled parts were built. Provenance of the runs quotes it.
find_package(Git QUIET)
set(record_commit "null")
set(record_modified "null")
# `git archive` replaces this by the commit.
set(archived "$Format:%H$")
if(archived MATCHES "^[0-9a-f]+$")
  set(record_commit "\"${archived}\"")
  set(record_modified "false")
elseif(GIT_FOUND)
  execute_process(COMMAND "${GIT_EXECUTABLE}" rev-parse HEAD
    WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}" OUTPUT_VARIABLE commit ERROR_QUIET
    OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed)
  if(NOT failed)
    set(record_commit "\"${commit}\"")
    execute_process(COMMAND "${GIT_EXECUTABLE}" status --porcelain --untracked-files=no
      WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}" OUTPUT_VARIABLE changes ERROR_QUIET)
    if(changes STREQUAL "")
      set(record_modified "false")
    else()
      set(record_modified "true")
    endif()
  endif()
endif()

string(TOUPPER "${CMAKE_BUILD_TYPE}" type)
get_directory_property(options COMPILE_OPTIONS)
# The folder of the sources says nothing about the code.
list(FILTER options EXCLUDE REGEX "^-ffile-prefix-map")
list(JOIN options " " options)
string(STRIP "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${type}} ${options}" record_flags)
get_filename_component(record_library "${LIGGGHTS_LIBRARY}" REALPATH)
get_filename_component(record_library "${record_library}" NAME)
string(REGEX REPLACE "[\"\\\\\n]+" " " record_mpi "${MPI_CXX_LIBRARY_VERSION_STRING}")
string(STRIP "${record_mpi}" record_mpi)
configure_file("${CMAKE_CURRENT_LIST_DIR}/build.json.in" "${PROJECT_BINARY_DIR}/build.json" @ONLY)
