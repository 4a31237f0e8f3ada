# What `cmake --install` puts where, for projects that use the libraries: find_package(ScalableIsosurface).
#   include/scalable-isosurface        headers of the VTK classes
#   include/scalable-isosurface/core   public headers of Core and Formats
#   lib/cmake/ScalableIsosurface       the package: targets ScalableIsosurface::Core, ::Filters, ...
set(ISOSURFACE_HEADERS "${CMAKE_INSTALL_INCLUDEDIR}/scalable-isosurface")
set(ISOSURFACE_PACKAGE "${CMAKE_INSTALL_LIBDIR}/cmake/ScalableIsosurface")

# The headers of Core and Formats in `result` that the given ones include, themselves included. Paths are
# relative to Core/, or begin with Formats/.
function(isosurface_find_header result header)
  if(header MATCHES "^Formats/")
    set(${result} "${PROJECT_SOURCE_DIR}/${header}" PARENT_SCOPE)
  else()
    set(${result} "${PROJECT_SOURCE_DIR}/Core/${header}" PARENT_SCOPE)
  endif()
endfunction()

function(isosurface_find_included result)
  set(open ${ARGN})
  set(found)
  while(open)
    list(POP_FRONT open header)
    if(header IN_LIST found)
      continue()
    endif()
    list(APPEND found "${header}")
    isosurface_find_header(file "${header}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
    file(STRINGS "${file}" lines REGEX "^#include \"[A-Za-z]+/")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
      list(APPEND open "${included}")
    endforeach()
  endwhile()
  set(${result} "${found}" PARENT_SCOPE)
endfunction()

isosurface_find_included(headers ${ISOSURFACE_PUBLIC_CORE_HEADERS} ${ISOSURFACE_PUBLIC_FORMATS_HEADERS})
foreach(header IN LISTS headers)
  get_filename_component(room "${header}" DIRECTORY)
  isosurface_find_header(file "${header}")
  install(FILES "${file}"
    DESTINATION "${ISOSURFACE_HEADERS}/core/${room}" COMPONENT development)
endforeach()

foreach(library IN ITEMS Core Formats)
  set_target_properties(Isosurface${library} PROPERTIES
    EXPORT_NAME ${library} VERSION "${PROJECT_VERSION}" SOVERSION "${PROJECT_VERSION_MAJOR}")
  target_compile_features(Isosurface${library} PUBLIC cxx_std_17)
  target_include_directories(Isosurface${library} INTERFACE "$<INSTALL_INTERFACE:${ISOSURFACE_HEADERS}/core>")
  install(TARGETS Isosurface${library} EXPORT ScalableIsosurfaceCore
    LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT plugin NAMELINK_COMPONENT development)
endforeach()
# The modules of formats lie beside Formats, which loads them.
get_property(modules GLOBAL PROPERTY ISOSURFACE_FORMAT_MODULES)
set_target_properties(IsosurfaceFormats ${modules} PROPERTIES INSTALL_RPATH "$ORIGIN")
foreach(module IN LISTS modules)
  get_target_property(component ${module} ISOSURFACE_COMPONENT)
  install(TARGETS ${module} LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT ${component})
endforeach()
export(EXPORT ScalableIsosurfaceCore
  NAMESPACE ScalableIsosurface::
  FILE "${PROJECT_BINARY_DIR}/${ISOSURFACE_PACKAGE}/ScalableIsosurfaceCore-targets.cmake")
install(EXPORT ScalableIsosurfaceCore
  NAMESPACE ScalableIsosurface::
  FILE ScalableIsosurfaceCore-targets.cmake
  DESTINATION "${ISOSURFACE_PACKAGE}"
  COMPONENT development)

include(CMakePackageConfigHelpers)
configure_package_config_file(
  CMake/ScalableIsosurfaceConfig.cmake.in "${PROJECT_BINARY_DIR}/CMake/ScalableIsosurfaceConfig.cmake"
  INSTALL_DESTINATION "${ISOSURFACE_PACKAGE}"
  NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/CMake/ScalableIsosurfaceConfigVersion.cmake"
  COMPATIBILITY SameMajorVersion)
install(
  FILES
    CMake/DebianParaView.cmake
    "${PROJECT_BINARY_DIR}/CMake/ScalableIsosurfaceConfig.cmake"
    "${PROJECT_BINARY_DIR}/CMake/ScalableIsosurfaceConfigVersion.cmake"
  DESTINATION "${ISOSURFACE_PACKAGE}"
  COMPONENT development)

# ParaView's functions install the archives of which the plugin is linked, without a way to say no.
function(isosurface_leave_out_client_server_archives)
  if(BUILD_SHARED_LIBS)
    install(
      CODE "file(GLOB archives \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}/libIsosurface*CS.a\")
  if(archives)
    file(REMOVE \${archives})
  endif()"
      COMPONENT development)
  endif()
endfunction()
