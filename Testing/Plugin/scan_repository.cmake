# Makes and configures the project of PluginFolder.cmake. Usage:
#   cmake -DREPOSITORY=... -DFOLDER=... -DGENERATOR=... -DParaView_DIR=... -P scan_repository.cmake
cmake_minimum_required(VERSION 3.18)
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}/source/Plugins")
configure_file("${REPOSITORY}/Testing/Plugin/PluginFolder.cmake" "${FOLDER}/source/CMakeLists.txt"
  COPYONLY)
file(CREATE_LINK "${REPOSITORY}" "${FOLDER}/source/Plugins/ScalableIsosurface" SYMBOLIC)
execute_process(
  COMMAND "${CMAKE_COMMAND}" -G "${GENERATOR}" -S "${FOLDER}/source" -B "${FOLDER}/build"
    "-DParaView_DIR=${ParaView_DIR}"
  RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "The project cannot be configured")
endif()
