# Fails if a library needs one that reads a format of others.
#   cmake -DREADELF=<readelf> -DLIBRARIES=<files> -P check_linked.cmake
cmake_minimum_required(VERSION 3.18)
foreach(library IN LISTS LIBRARIES)
  execute_process(COMMAND "${READELF}" -d "${library}" OUTPUT_VARIABLE linked RESULT_VARIABLE result)
  if(NOT result EQUAL 0 OR NOT linked MATCHES "libstdc")
    message(FATAL_ERROR "${library} cannot be read")
  endif()
  if(linked MATCHES "lib(tiff|gdcm|hdf5|netcdf|blosc|pugixml)[^]]*")
    message(FATAL_ERROR "${library} needs ${CMAKE_MATCH_0}")
  endif()
endforeach()
