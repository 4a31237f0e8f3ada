# Installs the build, moves the installed files, and uses them as another project does.
#   cmake -DBUILD=<build tree> -DFOLDER=<scratch folder> -DPARAVIEW_DIR=<folder of ParaView's package>
#         -DVTK_DIR=<folder of VTK's package, where there is no ParaView>
#         -DLAUNCHER=<compiler launcher> -DPYTHON=<python3> -DPYTHON_DESTINATION=<below the prefix>
#         -P use_installed.cmake
cmake_minimum_required(VERSION 3.18)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "${command} failed (${result}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# The package must not know where it was installed first.
file(REMOVE_RECURSE "${FOLDER}")
run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${FOLDER}/first")
file(RENAME "${FOLDER}/first" "${FOLDER}/prefix")

foreach(consumer IN ITEMS Core Formats VTK)
  set(consumer_build "${FOLDER}/${consumer}")
  run("${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}/${consumer}" -B "${consumer_build}"
    "-DCMAKE_PREFIX_PATH=${FOLDER}/prefix" "-DParaView_DIR=${PARAVIEW_DIR}" "-DVTK_DIR=${VTK_DIR}"
    "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" -DCMAKE_BUILD_TYPE=Release)
  run("${CMAKE_COMMAND}" --build "${consumer_build}")
  run("${CMAKE_COMMAND}" -E chdir "${consumer_build}" ./Installed${consumer})
  if(NOT output MATCHES "^8 (triangles|samples)")
    message(FATAL_ERROR "Installed${consumer} said: ${output}")
  endif()
endforeach()

# A program in C, and a module of a format beside the library.
file(GLOB library "${FOLDER}/prefix/lib/libscalable_isosurface.so" "${FOLDER}/prefix/lib/*/libscalable_isosurface.so")
get_filename_component(libraries "${library}" DIRECTORY)
file(WRITE "${FOLDER}/cube_2x2x2_uint8.raw" "abcdefgh")
run(cc -std=c99 "${CMAKE_CURRENT_LIST_DIR}/../../Examples/surface_in_c.c" "-I${FOLDER}/prefix/include"
  "-L${libraries}" "-Wl,-rpath,${libraries}" -lscalable_isosurface -o "${FOLDER}/surface_in_c")
run("${FOLDER}/surface_in_c" "${FOLDER}/cube_2x2x2_uint8.raw" 100.5 "${FOLDER}/cube.obj")
if(NOT output MATCHES "2 x 2 x 2 uint8.*the surface of 100.5 has 2 triangles")
  message(FATAL_ERROR "The program in C said: ${output}")
endif()

# Whoever wants a newer version than the installed one is told so.
file(WRITE "${FOLDER}/newer/CMakeLists.txt"
  "cmake_minimum_required(VERSION 3.18)\nproject(Newer LANGUAGES CXX)\nfind_package(ScalableIsosurface 99 REQUIRED)\n")
execute_process(
  COMMAND "${CMAKE_COMMAND}" -S "${FOLDER}/newer" -B "${FOLDER}/newer/build" "-DCMAKE_PREFIX_PATH=${FOLDER}/prefix"
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(result EQUAL 0 OR NOT output MATCHES "requested version \"99\"")
  message(FATAL_ERROR "A requirement of version 99 was answered by: ${output}")
endif()

# Commands and the Python package find their libraries.
if(EXISTS "${FOLDER}/prefix/bin/blockvolume")
  run("${FOLDER}/prefix/bin/blockvolume" --version)
endif()
if(PYTHON_DESTINATION)
  run("${CMAKE_COMMAND}" -E env "PYTHONPATH=${FOLDER}/prefix/${PYTHON_DESTINATION}" "${PYTHON}" -B -c
    "import scalable_isosurface as package\nprint(package.__file__, package.open, package.vtkStabbingContour())")
  if(NOT output MATCHES "^${FOLDER}/prefix")
    message(FATAL_ERROR "The Python package came from ${output}")
  endif()
endif()

# Headers that are not public stay here, and so does what only the plugin was linked of.
foreach(internal IN ITEMS ControllerCommunicator.h PipelineSource.h core/Storage/Store/JsonDocument.h core/Formats/Opener/VolumeFormat.h)
  if(EXISTS "${FOLDER}/prefix/include/scalable-isosurface/${internal}")
    message(FATAL_ERROR "${internal} was installed")
  endif()
endforeach()
file(GLOB_RECURSE archives "${FOLDER}/prefix/*.a")
file(GLOB headers LIST_DIRECTORIES OFF "${FOLDER}/prefix/include/*")
list(REMOVE_ITEM headers "${FOLDER}/prefix/include/scalable_isosurface.h")
if(archives OR headers)
  message(FATAL_ERROR "What nobody needs was installed: ${archives} ${headers}")
endif()
