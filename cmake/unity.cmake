# Nearly all of the time of compiling a file alone goes to the headers that it includes. maquette_unity(target) compiles the
# files of a folder together, in equal groups of at most MAQUETTE_UNITY_FILES, so that a change of one file compiles few
# others. `-DCMAKE_UNITY_BUILD=OFF` compiles each file alone.
#
# Names of unnamed namespaces must differ within a folder. Left out are files that say so (SKIP_UNITY_BUILD_INCLUSION) and,
# by CMake, those with options of their own.
if(NOT DEFINED CMAKE_UNITY_BUILD)
  set(CMAKE_UNITY_BUILD ON)
endif()
set(MAQUETTE_UNITY_FILES 8)

function(maquette_unity target)
  get_target_property(sources ${target} SOURCES)
  list(SORT sources)
  set(folders)
  foreach(source IN LISTS sources)
    cmake_path(ABSOLUTE_PATH source)
    cmake_path(GET source PARENT_PATH folder)
    list(APPEND folders ${folder})
    list(APPEND files_${folder} ${source})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder IN LISTS folders)
    list(LENGTH files_${folder} count)
    math(EXPR groups "(${count} + ${MAQUETTE_UNITY_FILES} - 1) / ${MAQUETTE_UNITY_FILES}")
    cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${CMAKE_SOURCE_DIR} OUTPUT_VARIABLE name)
    string(REPLACE "/" "_" name ${name})
    set(at 0)
    foreach(source IN LISTS files_${folder})
      math(EXPR group "${at} * ${groups} / ${count}")
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${name}_${group})
      math(EXPR at "${at} + 1")
    endforeach()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
  if(CMAKE_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # A file's own types are taken for those of a header, since another file includes it.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()
