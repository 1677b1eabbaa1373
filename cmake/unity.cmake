# Nearly all of the time of compiling a file alone goes to the headers that it includes. maquette_unity(target) compiles
# files together, at most MAQUETTE_UNITY_FILES in a group: small folders that follow each other as one group, a larger
# folder in equal groups, so that a change of one file compiles few others. `-DCMAKE_UNITY_BUILD=OFF` compiles each file
# alone.
#
# Names of unnamed namespaces must differ within a target's folder, and within small folders that follow each other. Left
# out are files that say so (SKIP_UNITY_BUILD_INCLUSION) and, by CMake, those with options of their own.
if(NOT DEFINED CMAKE_UNITY_BUILD)
  set(CMAKE_UNITY_BUILD ON)
endif()
set(MAQUETTE_UNITY_FILES 16)

function(maquette_unity target)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources EXCLUDE REGEX "^[$]<")  # objects of another target
  list(SORT sources)
  set(folders)
  foreach(source IN LISTS sources)
    cmake_path(ABSOLUTE_PATH source)
    cmake_path(GET source PARENT_PATH folder)
    list(APPEND folders ${folder})
    list(APPEND files_${folder} ${source})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  set(name "")     # of the group that small folders join
  set(together 0)  # its files so far
  foreach(folder IN LISTS folders)
    list(LENGTH files_${folder} count)
    math(EXPR groups "(${count} + ${MAQUETTE_UNITY_FILES} - 1) / ${MAQUETTE_UNITY_FILES}")
    math(EXPR together "${together} + ${count}")
    if(groups GREATER 1 OR together GREATER MAQUETTE_UNITY_FILES OR name STREQUAL "")
      cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${CMAKE_SOURCE_DIR} OUTPUT_VARIABLE name)
      string(REPLACE "/" "_" name ${name})
      set(together ${count})
    endif()
    set(at 0)
    foreach(source IN LISTS files_${folder})
      math(EXPR group "${at} * ${groups} / ${count}")
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${name}_${group})
      math(EXPR at "${at} + 1")
    endforeach()
    if(groups GREATER 1)
      set(name "")
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
  if(CMAKE_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # A file's own types are taken for those of a header, since another file includes it.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()
