# The CMakeLists.txt of a project that has this repository in its folder Plugins and looks there for
# plugins, as ParaView does: there is one, and CMake can add it.
cmake_minimum_required(VERSION 3.18)
project(PluginFolder LANGUAGES C CXX)
include(Plugins/ScalableIsosurface/CMake/DebianParaView.cmake)
find_package(ParaView 5.11 REQUIRED)
include(GNUInstallDirs)

set(repository "${CMAKE_CURRENT_SOURCE_DIR}/Plugins/ScalableIsosurface")
paraview_plugin_find_plugins(manifests "${repository}")
if(NOT manifests STREQUAL "${repository}/paraview.plugin")
  message(FATAL_ERROR "Not one plugin, but: ${manifests}")
endif()
paraview_plugin_scan(
  PLUGIN_FILES ${manifests}
  PROVIDES_PLUGINS plugins
  ENABLE_BY_DEFAULT ON)
paraview_plugin_build(PLUGINS ${plugins})
if(NOT TARGET ScalableIsosurface)
  message(FATAL_ERROR "The plugin was not added")
endif()
