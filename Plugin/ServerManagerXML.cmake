# One document of all proxies: at each one that a plugin brings, ParaView's window makes all of its menus anew.
# @NAME@ in it stands for the file NAME.xml of Parts, which several proxies have, or, if NAME is FORMAT_EXTENSIONS, for
# the endings of names in the table of formats.
function(isosurface_write_server_manager_xml output)
  set(formats "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../Formats/Opener/VolumeFormat.cxx")
  file(READ "${formats}" table)
  string(REGEX MATCHALL "\n    { \"?[A-Za-z0-9]+\"?, { \"[^}]*" rows "${table}")
  foreach(row IN LISTS rows)
    string(REGEX MATCH "[A-Za-z0-9]+" format "${row}")
    string(REGEX MATCHALL "\"\\.[a-z0-9.]+" endings "${row}")
    list(JOIN endings " " ${format}_EXTENSIONS)
    string(REPLACE "\"." "" ${format}_EXTENSIONS "${${format}_EXTENSIONS}")
  endforeach()
  set(part_files)
  foreach(part IN ITEMS GridProperties OutputProperties RefinementProperty)
    list(APPEND part_files "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/XML/Parts/${part}.xml")
    file(READ "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/XML/Parts/${part}.xml" ${part})
  endforeach()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${formats}" ${part_files})
  set(definitions)
  foreach(name IN ITEMS
      BlockedVolumeReader
      BlockedVolumeWriter
      ContourSpectrum
      DistributeIsosurface
      EdgeIndexReader
      EdgeIndexWriter
      InPlaceVolumeReader
      IsosurfaceRepresentation
      MetabufferRenderView
      PluginLoader
      StabbingContour
      VolumeProbe
      VolumeRegion
      VolumeSlice)
    set(file "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/XML/${name}.xml")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
    file(READ "${file}" definition)
    string(REGEX REPLACE "</?ServerManagerConfiguration>" "" definition "${definition}")
    string(CONFIGURE "${definition}" definition @ONLY)
    string(APPEND definitions "${definition}")
  endforeach()
  # CMake 3.18 refuses < in a content, and @ONLY before it.
  set(document "<ServerManagerConfiguration>${definitions}</ServerManagerConfiguration>\n")
  file(CONFIGURE OUTPUT "${output}" CONTENT "@document@" @ONLY)
endfunction()
