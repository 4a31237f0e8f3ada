# To be included before find_package(ParaView): works around a fault of Debian 13's package paraview-dev.
# Its Python modules are named vtkX.cpython-313-x86_64-linux-gnu.so, but its CMake files say vtkX.so, and
# stop because there is no such file. Nothing here links to a Python module, so the check of exactly these
# targets is skipped: CMake (3.28 or newer) skips it for a target with a framework folder, so they get one.
file(GLOB _isosurface_lists
  "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/paraview-*/ParaViewPython*-targets-*.cmake"
  "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/paraview-*/vtk/VTKPython-targets-*.cmake")
foreach(_isosurface_list IN LISTS _isosurface_lists)
  file(STRINGS "${_isosurface_list}" _isosurface_checks REGEX "_cmake_import_check_files_for_")
  foreach(_isosurface_check IN LISTS _isosurface_checks)
    if(NOT _isosurface_check MATCHES "_files_for_([A-Za-z0-9_:]+) \"\\\${_IMPORT_PREFIX}/(.+)\\.so\"")
      continue()
    endif()
    set(_isosurface_target "${CMAKE_MATCH_1}")
    set(_isosurface_module "/usr/${CMAKE_MATCH_2}")
    file(GLOB _isosurface_named "${_isosurface_module}.cpython-*.so")
    if(_isosurface_named AND NOT EXISTS "${_isosurface_module}.so")
      set("_cmake_import_check_xcframework_for_${_isosurface_target}" "${CMAKE_CURRENT_LIST_DIR}")
    endif()
  endforeach()
endforeach()
foreach(_isosurface_variable IN ITEMS lists list checks check target module named)
  unset(_isosurface_${_isosurface_variable})
endforeach()
unset(_isosurface_variable)
