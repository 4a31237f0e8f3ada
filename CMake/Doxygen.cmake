# The target `documentation`: pages about the C++ API, of what is installed, in documentation/html of the
# build folder. Needs doxygen. A warning is an error.
find_package(Doxygen QUIET)
if(NOT DOXYGEN_FOUND)
  return()
endif()
set(DOXYGEN_PROJECT_NAME "ScalableIsosurface")
set(DOXYGEN_PROJECT_BRIEF "${PROJECT_DESCRIPTION}")
set(DOXYGEN_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/documentation")
set(DOXYGEN_STRIP_FROM_PATH "${PROJECT_SOURCE_DIR}")
set(DOXYGEN_STRIP_FROM_INC_PATH "${PROJECT_SOURCE_DIR}/Core")
set(DOXYGEN_JAVADOC_AUTOBRIEF YES)
set(DOXYGEN_GENERATE_LATEX NO)
set(DOXYGEN_HAVE_DOT NO)
set(DOXYGEN_EXTRACT_ALL YES)
set(DOXYGEN_HIDE_UNDOC_RELATIONS YES)
set(DOXYGEN_QUIET YES)
set(DOXYGEN_WARN_AS_ERROR FAIL_ON_WARNINGS)
set(DOXYGEN_MACRO_EXPANSION YES)
set(DOXYGEN_EXPAND_ONLY_PREDEF YES)
set(DOXYGEN_PREDEFINED
  "vtkTypeMacro(a,b)=" "vtkGetMacro(name,type)=virtual type Get##name()"
  "vtkSetMacro(name,type)=virtual void Set##name(type)"
  "vtkBooleanMacro(name,type)=virtual void name##On()")

isosurface_find_included(core ${ISOSURFACE_PUBLIC_CORE_HEADERS})
list(TRANSFORM core PREPEND "${PROJECT_SOURCE_DIR}/Core/")
set(classes)
foreach(room IN LISTS ISOSURFACE_VTK_ROOMS)
  file(GLOB headers "${PROJECT_SOURCE_DIR}/${room}/vtk*.h")
  list(APPEND classes ${headers})
endforeach()
list(FILTER classes EXCLUDE REGEX "vtkBlockedVolumeHandle|vtkInformationBlockedVolumeKey|vtkBlockConsumerPipeline|vtkIsosurfaceMapperHelper")
doxygen_add_docs(documentation ${core} ${classes} COMMENT "Pages about the C++ API")
