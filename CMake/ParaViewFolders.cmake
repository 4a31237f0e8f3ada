# Below any prefix, files are installed to the places that they would have below ParaView's own one. With
# that as the prefix, the plugin is where ParaView looks for it, and so are the Python modules.
#   ISOSURFACE_PARAVIEW_LIBDIR   ParaView's libraries, relative to its prefix
#   ISOSURFACE_PLUGIN_FOLDER     the plugin and the VTK modules, relative to the prefix
#   ISOSURFACE_PLUGIN_LIST       the list of plugins that names ours, relative to the prefix
get_target_property(_isosurface_library ParaView::RemotingCore LOCATION)
get_filename_component(_isosurface_folder "${_isosurface_library}" DIRECTORY)
file(RELATIVE_PATH ISOSURFACE_PARAVIEW_LIBDIR "${ParaView_PREFIX_PATH}" "${_isosurface_folder}")
unset(_isosurface_library)
unset(_isosurface_folder)
if(ISOSURFACE_PARAVIEW_LIBDIR MATCHES "^\\.\\.")
  set(ISOSURFACE_PARAVIEW_LIBDIR lib) # ParaView's own build tree
endif()
if(NOT libdir_is_chosen)
  set(CMAKE_INSTALL_LIBDIR "${ISOSURFACE_PARAVIEW_LIBDIR}" CACHE PATH "Object code libraries (lib)" FORCE)
endif()
set(ISOSURFACE_PLUGIN_FOLDER "${CMAKE_INSTALL_LIBDIR}/${PARAVIEW_PLUGIN_SUBDIR}/ScalableIsosurface")
set(ISOSURFACE_PLUGIN_LIST "${ISOSURFACE_PLUGIN_FOLDER}.xml")
