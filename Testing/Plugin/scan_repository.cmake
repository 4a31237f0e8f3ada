# Makes and configures the project of PluginFolder.cmake. With PVBATCH it also builds the plugin there, and
# pvbatch loads it. Usage:
#   cmake -DREPOSITORY=... -DFOLDER=... -DGENERATOR=... -DParaView_DIR=... [-DPVBATCH=...] [-DLAUNCHER=...]
#         -P scan_repository.cmake
cmake_minimum_required(VERSION 3.18)
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}/source/Plugins")
configure_file("${REPOSITORY}/Testing/Plugin/PluginFolder.cmake" "${FOLDER}/source/CMakeLists.txt"
  COPYONLY)
file(CREATE_LINK "${REPOSITORY}" "${FOLDER}/source/Plugins/ScalableIsosurface" SYMBOLIC)
execute_process(
  COMMAND "${CMAKE_COMMAND}" -G "${GENERATOR}" -S "${FOLDER}/source" -B "${FOLDER}/build"
    "-DParaView_DIR=${ParaView_DIR}" -DBUILD_SHARED_LIBS=ON -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0
    -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=12 "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}"
  RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "The project cannot be configured")
endif()
if(PVBATCH)
  execute_process(COMMAND "${CMAKE_COMMAND}" --build "${FOLDER}/build" RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "The plugin cannot be built")
  endif()
  file(GLOB_RECURSE plugin "${FOLDER}/build/*/ScalableIsosurface.so")
  file(WRITE "${FOLDER}/load.py"
    "from paraview.simple import *\n"
    "LoadPlugin('${plugin}', remote=True, ns=globals())\n"
    "surface = Isosurface(Input=Wavelet(), ContourBy=['POINTS', 'RTData'], Isosurfaces=[150.0])\n"
    "surface.UpdatePipeline()\n"
    "assert surface.GetDataInformation().GetNumberOfCells() > 0\n")
  execute_process(COMMAND "${PVBATCH}" "${FOLDER}/load.py" RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "The plugin ${plugin} cannot be used")
  endif()
endif()
