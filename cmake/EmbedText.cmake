# mor_embed_text(TARGET FILE...): each FILE becomes "embedded/NAME.inc", a C++ string literal with its
# text, which TARGET includes: `constexpr const char* kText = \n#include "embedded/NAME.inc"\n;`
# Runs at build time, whenever the file changes. Called as a script (cmake -P) it writes one of them.
if(CMAKE_SCRIPT_MODE_FILE)
  file(READ ${EMBED_INPUT} text)
  file(WRITE ${EMBED_OUTPUT} "R\"mor_text(${text})mor_text\"\n")
  return()
endif()

set(MOR_EMBED_TEXT_SCRIPT ${CMAKE_CURRENT_LIST_FILE})

function(mor_embed_text target)
  foreach(input ${ARGN})
    cmake_path(GET input FILENAME name)
    set(output ${CMAKE_CURRENT_BINARY_DIR}/embedded/${name}.inc)
    add_custom_command(
      OUTPUT ${output}
      COMMAND ${CMAKE_COMMAND} -DEMBED_INPUT=${input} -DEMBED_OUTPUT=${output} -P ${MOR_EMBED_TEXT_SCRIPT}
      DEPENDS ${input} ${MOR_EMBED_TEXT_SCRIPT}
      VERBATIM)
    target_sources(${target} PRIVATE ${output})
  endforeach()
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR})
endfunction()
