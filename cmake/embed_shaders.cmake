# Makes every file of shaders/ part of the library: render/gl/shader_source.h reads them by their path below shaders/.
function(maquette_embed_shaders target)
  file(GLOB_RECURSE shaders CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/shaders/*.glsl ${CMAKE_SOURCE_DIR}/shaders/*.vert
       ${CMAKE_SOURCE_DIR}/shaders/*.frag ${CMAKE_SOURCE_DIR}/shaders/*.comp)
  set(output ${CMAKE_BINARY_DIR}/embedded_shaders.cpp)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DROOT=${CMAKE_SOURCE_DIR}/shaders "-DFILES=${shaders}"
            -P ${CMAKE_SOURCE_DIR}/cmake/write_embedded_shaders.cmake
    DEPENDS ${shaders} ${CMAKE_SOURCE_DIR}/cmake/write_embedded_shaders.cmake
    VERBATIM)
  target_sources(${target} PRIVATE ${output})
endfunction()
