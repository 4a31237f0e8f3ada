# Makes pages for ParaView's help of the documentation for users, with its images. Needs cmark-gfm.
#   isosurface_make_help_pages(<documentation folder> <output folder>)
# The pages are in one folder, those of Documentation/reference, too.
set(ISOSURFACE_HELP_PAGES tour window user-guide install writing in-place replicas command-line reading isosurfaces
  levels choosing-isovalues edge-index many-ranks python cpp troubleshooting)

# Gives headings the names that links have for them.
function(isosurface_name_headings variable)
  string(REGEX MATCHALL "<h[23]>[^\n]+</h[23]>" headings "${${variable}}")
  foreach(heading IN LISTS headings)
    string(REGEX REPLACE "<[^>]+>" "" name "${heading}")
    string(TOLOWER "${name}" name)
    string(REGEX REPLACE "[^a-z0-9 -]" "" name "${name}")
    string(REPLACE " " "-" name "${name}")
    string(REGEX REPLACE "^<(h[23])>" "<\\1 id=\"${name}\">" named "${heading}")
    string(REPLACE "${heading}" "${named}" ${variable} "${${variable}}")
  endforeach()
  set(${variable} "${${variable}}" PARENT_SCOPE)
endfunction()

function(isosurface_make_help_pages documentation output)
  foreach(folder IN ITEMS tour panels)
    file(COPY "${documentation}/images/${folder}" DESTINATION "${output}/images")
  endforeach()
  foreach(page IN LISTS ISOSURFACE_HELP_PAGES)
    set(source "${documentation}/${page}.md")
    if(NOT EXISTS "${source}")
      set(source "${documentation}/reference/${page}.md")
    endif()
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
    execute_process(COMMAND "${ISOSURFACE_CMARK}" --extension table "${source}"
      OUTPUT_VARIABLE text RESULT_VARIABLE result)
    if(NOT result EQUAL 0)
      message(FATAL_ERROR "${ISOSURFACE_CMARK} cannot read ${source}")
    endif()
    isosurface_name_headings(text)
    # Pages link to each other; the rest of the repository is not in the help.
    foreach(other IN LISTS ISOSURFACE_HELP_PAGES)
      string(REGEX REPLACE "href=\"(\\.\\./|reference/)?${other}\\.md" "href=\"${other}.html" text "${text}")
    endforeach()
    string(REGEX REPLACE "<a href=\"[^\"#]*(\\.md[^\"]*|[^l\"#])\">([^<]*)</a>" "\\2" text "${text}")
    string(REGEX REPLACE "<a href=\"\\.\\./[^\"]*\">([^<]*)</a>" "\\1" text "${text}")
    string(REGEX MATCH "<h1>([^<]*)</h1>" title "${text}")
    set(text
      "<html><head><meta charset=\"utf-8\"/><title>${CMAKE_MATCH_1}</title></head><body>\n${text}</body></html>\n")
    set(before)
    if(EXISTS "${output}/${page}.html")
      file(READ "${output}/${page}.html" before)
    endif()
    if(NOT text STREQUAL before) # else the plugin would be linked after every configuration
      file(WRITE "${output}/${page}.html" "${text}")
    endif()
  endforeach()
endfunction()
