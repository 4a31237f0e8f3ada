# VTK without ParaView, 9.1 or newer, and the rooms that it has what they need for: ISOSURFACE_VTK_ROOMS.
find_package(VTK 9.1 QUIET
  COMPONENTS
    CommonCore CommonDataModel CommonExecutionModel CommonMath CommonMisc CommonTransforms FiltersCore
    FiltersGeneral FiltersModeling FiltersParallel FiltersSources IOCore IOGeometry IOImage IOLegacy IOPLY IOXML
    ImagingCore ParallelCore RenderingCore
  OPTIONAL_COMPONENTS
    ParallelMPI RenderingOpenGL2 TestingCore WrappingPythonCore Python opengl glad glew)
if(NOT VTK_FOUND)
  message(FATAL_ERROR
    "VTK 9.1 or newer is not found (Debian: libvtk9-dev). VTK_DIR may say where it is; "
    "-DISOSURFACE_VTK=OFF builds Core alone. ${VTK_NOT_FOUND_MESSAGE}")
endif()

set(ISOSURFACE_VTK_ROOMS Bridge Readers Filters Writers)
message(STATUS "The VTK classes are built beside VTK ${VTK_VERSION}, without ParaView")
message(STATUS "Left out, for want of ParaView: plugin, Rendering, Representation, Debian packages")
if(TARGET VTK::RenderingOpenGL2)
  list(APPEND ISOSURFACE_VTK_ROOMS Surfaces)
else()
  message(STATUS "Left out, for want of VTK's RenderingOpenGL2: Surfaces")
endif()
if(NOT TARGET VTK::ParallelMPI)
  message(STATUS "Left out, for want of VTK's ParallelMPI: Tools, tests on several ranks")
endif()
if(NOT TARGET VTK::WrappingPythonCore)
  message(STATUS "Left out, for want of VTK's wrappers: Python")
elseif(VTK_VERSION VERSION_LESS 9.2)
  message(STATUS "Left out, since VTK ${VTK_VERSION} makes none: type hints of Python")
endif()
