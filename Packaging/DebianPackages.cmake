# Packages for Debian, of the components of the installation:
#   scalable-isosurface           the plugin, the commands, the libraries
#   scalable-isosurface-hdf5      the modules that read HDF5 and NetCDF, whose libraries are many
#   scalable-isosurface-dicom     the module that reads DICOM
#   python3-scalable-isosurface   the package scalable_isosurface
#   scalable-isosurface-dev       headers and the package for CMake
# They depend on exactly the ParaView that they were built with: dpkg-shlibdeps knows the versions whose
# libraries fit.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME scalable-isosurface)
set(CPACK_PACKAGE_VENDOR "ScalableIsosurface")
set(CPACK_PACKAGE_CONTACT "ScalableIsosurface <scalable-isosurface@localhost>")
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_RESOURCE_FILE_LICENSE "${PROJECT_SOURCE_DIR}/LICENSE")
set(CPACK_PACKAGING_INSTALL_PREFIX "${ParaView_PREFIX_PATH}")
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 0)
set(CPACK_VERBATIM_VARIABLES ON)

set(CPACK_COMPONENTS_ALL plugin commands python development hdf5 dicom)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENT_PLUGIN_GROUP main)
set(CPACK_COMPONENT_COMMANDS_GROUP main)
set(CPACK_COMPONENT_PYTHON_GROUP python)
set(CPACK_COMPONENT_DEVELOPMENT_GROUP development)
set(CPACK_COMPONENT_HDF5_GROUP hdf5)
set(CPACK_COMPONENT_DICOM_GROUP dicom)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS
  "${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR}" "${PROJECT_BINARY_DIR}/${ISOSURFACE_PLUGIN_FOLDER}")

set(CPACK_DEBIAN_MAIN_PACKAGE_NAME scalable-isosurface)
set(CPACK_DEBIAN_MAIN_DESCRIPTION "isosurfaces of volumes far larger than memory, for ParaView
A ParaView plugin and commands. A volume is cut once into blocks with an
index; an isovalue then reads only the blocks that it crosses, on any number
of MPI ranks, and gives one watertight surface.")
set(CPACK_DEBIAN_MAIN_PACKAGE_CONTROL_EXTRA
  "${CMAKE_CURRENT_BINARY_DIR}/postinst" "${CMAKE_CURRENT_BINARY_DIR}/prerm" "${CMAKE_CURRENT_BINARY_DIR}/triggers")
set(CPACK_DEBIAN_MAIN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_MAIN_PACKAGE_RECOMMENDS "bash-completion")
set(CPACK_DEBIAN_MAIN_PACKAGE_SUGGESTS "scalable-isosurface-hdf5, scalable-isosurface-dicom")

foreach(format IN ITEMS HDF5 DICOM)
  string(TOLOWER "${format}" package)
  set(CPACK_DEBIAN_${format}_PACKAGE_NAME scalable-isosurface-${package})
  set(CPACK_DEBIAN_${format}_PACKAGE_DEPENDS "scalable-isosurface (= ${PROJECT_VERSION})")
endforeach()
set(CPACK_DEBIAN_HDF5_DESCRIPTION "isosurfaces of volumes in files of HDF5 and NetCDF
The modules by which ScalableIsosurface reads them.")
set(CPACK_DEBIAN_DICOM_DESCRIPTION "isosurfaces of volumes in files of DICOM
The module by which ScalableIsosurface reads them.")

find_package(Python3 REQUIRED COMPONENTS Interpreter)
math(EXPR next_python "${Python3_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-scalable-isosurface)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "scalable-isosurface (= ${PROJECT_VERSION}), python3-paraview, python3 (>= ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}~), python3 (<< ${Python3_VERSION_MAJOR}.${next_python}~)")
file(WRITE "${CMAKE_CURRENT_BINARY_DIR}/python/prerm"
  "#!/bin/sh\n# What Python made of the modules.\nset -e\n"
  "rm -rf \"${ParaView_PREFIX_PATH}/${ISOSURFACE_PYTHON_DESTINATION}/scalable_isosurface/__pycache__\"\n")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${CMAKE_CURRENT_BINARY_DIR}/python/prerm")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "isosurfaces of volumes far larger than memory, in Python
The VTK classes of ScalableIsosurface as the package scalable_isosurface,
beside ParaView's Python modules.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME scalable-isosurface-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "scalable-isosurface (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS "paraview-dev")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "isosurfaces of volumes far larger than memory, for C++
Headers and the CMake package of ScalableIsosurface: its VTK classes, and
its Core, which needs no VTK.")
include(CPack)
