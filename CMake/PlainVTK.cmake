# The modules beside VTK alone. (Beside ParaView, the plugin builds them.) Libraries go where those of other
# projects are, ISOSURFACE_PLUGIN_FOLDER included.
set(ISOSURFACE_PLUGIN_FOLDER "${CMAKE_INSTALL_LIBDIR}")
list(TRANSFORM ISOSURFACE_VTK_ROOMS APPEND "/vtk.module" OUTPUT_VARIABLE module_files)
list(TRANSFORM module_files PREPEND "${PROJECT_SOURCE_DIR}/")
list(TRANSFORM ISOSURFACE_VTK_ROOMS PREPEND "ScalableIsosurface::" OUTPUT_VARIABLE requested)
vtk_module_scan(
  MODULE_FILES ${module_files}
  REQUEST_MODULES ${requested}
  PROVIDES_MODULES modules
  REQUIRES_MODULES required)
# Installed libraries find each other in their folder. VTK sees to that itself only since 9.3.
list(APPEND CMAKE_INSTALL_RPATH "$ORIGIN")
vtk_module_build(
  MODULES ${modules}
  PACKAGE ScalableIsosurface
  INSTALL_EXPORT ScalableIsosurface
  HEADERS_DESTINATION "${ISOSURFACE_HEADERS}"
  CMAKE_DESTINATION "${ISOSURFACE_PACKAGE}"
  LIBRARY_DESTINATION "${CMAKE_INSTALL_LIBDIR}"
  HEADERS_COMPONENT development
  TARGETS_COMPONENT plugin)
