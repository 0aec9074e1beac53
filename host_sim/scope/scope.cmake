# The library of the scope: a server for one page on this machine, and the page, whose parts are compiled into the program as
# texts.
set(scope_texts)
foreach(part html css js)
    set(file ${CMAKE_CURRENT_SOURCE_DIR}/scope/page/page.${part})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
    file(READ ${file} octets HEX)
    string(REGEX REPLACE "(................................)" "\\1\n" octets "${octets}")
    string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," octets "${octets}")
    string(APPEND scope_texts "const unsigned char page_${part}[] = {\n${octets}0};\n")
endforeach()
file(CONFIGURE OUTPUT scope_texts.c CONTENT
    "/* Made from host_sim/scope/page/. */\nextern const unsigned char page_html[], page_css[], page_js[];\n${scope_texts}" @ONLY)

add_library(lagless_scope STATIC
    scope/commission_line.c
    scope/http.c
    scope/page.c
    scope/scope.c
    scope/scope_capture.c
    scope/scope_commission.c
    scope/scope_text.c
    ${CMAKE_CURRENT_BINARY_DIR}/scope_texts.c
)
desk_room(lagless_scope)
target_compile_definitions(lagless_scope PRIVATE _GNU_SOURCE LAGLESS_ANY_BOARD)
target_link_libraries(lagless_scope PUBLIC lagless_line lagless_lab)
