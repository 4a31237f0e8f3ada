# Libraries of formats that a build may lack: then their modules are missing.
cmake_policy(VERSION 3.18)
find_package(PkgConfig REQUIRED)

#   isosurface_set_format(<name> [targets or files of the library]): ISOSURFACE_READS_<name>, and
#   ISOSURFACE_<name>_TARGETS
function(isosurface_set_format name)
  set(found no)
  if(ARGN)
    set(found yes)
  endif()
  set(ISOSURFACE_READS_${name} ${found} CACHE INTERNAL "Whether volumes of ${name} are read")
  set(ISOSURFACE_${name}_TARGETS ${ARGN} PARENT_SCOPE)
  message(STATUS "Volumes of ${name} are read: ${found}")
endfunction()

# The serial library first: NetCDF has it, too, and both builds of Debian have symbols with versions
# of their own, so that they bear each other in one process.
set(ISOSURFACE_HDF5_MODULES hdf5-serial hdf5-openmpi hdf5 CACHE STRING
  "Names of HDF5 in pkg-config; the first one that is there is taken")
pkg_search_module(ISOSURFACE_HDF5_LIBRARY IMPORTED_TARGET GLOBAL ${ISOSURFACE_HDF5_MODULES})
set(targets)
if(ISOSURFACE_HDF5_LIBRARY_FOUND)
  set(targets PkgConfig::ISOSURFACE_HDF5_LIBRARY)
  if(ISOSURFACE_HDF5_LIBRARY_MODULE_NAME MATCHES "mpi")
    find_package(MPI REQUIRED COMPONENTS C)
    list(APPEND targets MPI::MPI_C)
  endif()
endif()
isosurface_set_format(HDF5 ${targets})
option(ISOSURFACE_HDF5_IS_AN_ARCHIVE "Each module that uses HDF5 has a copy of it, and a lock of its own" OFF)

pkg_check_modules(ISOSURFACE_NETCDF_LIBRARY IMPORTED_TARGET GLOBAL netcdf)
set(targets)
if(ISOSURFACE_NETCDF_LIBRARY_FOUND AND ISOSURFACE_READS_HDF5) # which version 4 is
  set(targets PkgConfig::ISOSURFACE_NETCDF_LIBRARY)
endif()
isosurface_set_format(NETCDF ${targets})

# A codec of Zarr.
pkg_check_modules(ISOSURFACE_BLOSC_LIBRARY IMPORTED_TARGET GLOBAL blosc)
set(targets)
if(ISOSURFACE_BLOSC_LIBRARY_FOUND)
  set(targets PkgConfig::ISOSURFACE_BLOSC_LIBRARY)
endif()
isosurface_set_format(BLOSC ${targets})

# Debian's GDCMConfig.cmake wants packages that this project does not.
find_path(GDCM_INCLUDE_DIR gdcmImageReader.h PATH_SUFFIXES gdcm-3.0)
set(targets)
foreach(part IN ITEMS MSFF DSED DICT Common)
  find_library(GDCM_${part}_LIBRARY gdcm${part})
  if(GDCM_INCLUDE_DIR AND GDCM_${part}_LIBRARY)
    list(APPEND targets "${GDCM_${part}_LIBRARY}")
  endif()
endforeach()
isosurface_set_format(DICOM ${targets})
