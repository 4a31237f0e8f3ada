# Writes the tables of a text file as C++ arrays: cmake -DINPUT=<text> -DOUTPUT=<source> -P <this>.
#
# A table is a line "name type count" and then its numbers. From # to the end of a line is comment.
file(READ "${INPUT}" text)
string(REGEX REPLACE "#[^\n]*\n" "" text "${text}")
string(REGEX MATCHALL "[A-Za-z]+ [a-z0-9]+ [0-9]+\n[-0-9 \n]+" tables "${text}")
get_filename_component(name "${INPUT}" NAME)
set(source "// Made of ${name}; clang-tidy has nothing to say about it.\n// NOLINTBEGIN\n")
string(APPEND source "#include \"Coding/TrainedModels/TrainedTables.h\"\n")
foreach(table IN LISTS tables)
  string(REGEX MATCH "^([A-Za-z]+) ([a-z0-9]+) ([0-9]+)\n(.*)$" table "${table}")
  set(name "${CMAKE_MATCH_1}")
  set(type "std::${CMAKE_MATCH_2}_t")
  set(count "${CMAKE_MATCH_3}")
  string(REGEX MATCHALL "-?[0-9]+" numbers "${CMAKE_MATCH_4}")
  list(LENGTH numbers found)
  if(NOT found EQUAL count)
    message(FATAL_ERROR "${INPUT}: ${name} has ${found} numbers, not ${count}.")
  endif()
  string(REPLACE ";" ",\n" numbers "${numbers}")
  string(APPEND source
    "const std::array<${type}, ${count}> isosurface::${name} = { {\n${numbers}\n} };\n")
endforeach()
file(WRITE "${OUTPUT}" "${source}// NOLINTEND\n")
