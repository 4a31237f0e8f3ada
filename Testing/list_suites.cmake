# Writes a file for ctest with one test for each suite of a GoogleTest program:
#   cmake -DPROGRAM=<program> -DLABEL=<label> -DOUTPUT=<file> -P list_suites.cmake
cmake_minimum_required(VERSION 3.19)
execute_process(COMMAND "${PROGRAM}" --gtest_list_tests OUTPUT_VARIABLE list COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "\n[A-Za-z0-9_/]+[.]" lines "\n${list}")
set(suites)
foreach(line IN LISTS lines)
  # Instances of a suite are listed as Instance/Suite, those for a type as Suite/0.
  string(REGEX REPLACE "/[0-9]+[.]$|[.]$" "" suite "${line}")
  string(REGEX REPLACE "^\n(.*/)?" "" suite "${suite}")
  list(APPEND suites "${suite}")
endforeach()
if(NOT suites)
  message(FATAL_ERROR "${PROGRAM} has no tests")
endif()
list(REMOVE_DUPLICATES suites)
set(tests)
foreach(suite IN LISTS suites)
  string(APPEND tests
    "add_test([=[${LABEL}.${suite}]=] [=[${PROGRAM}]=] [=[--gtest_filter=${suite}.*:${suite}/*:*/${suite}.*:*/${suite}/*]=])\n"
    "set_tests_properties([=[${LABEL}.${suite}]=] PROPERTIES LABELS [=[${LABEL}]=])\n")
endforeach()
file(WRITE "${OUTPUT}" "${tests}")
