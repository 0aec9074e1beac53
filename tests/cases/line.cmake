# The serial line and the scope under disturbance, and the scope with pages that are not its own.
lagless_test(talk_noise LABEL rig SOURCES test_talk_noise.c LIBS lagless_rig m)
lagless_test(talk_chip LABEL rig SOURCES test_talk_chip.c LIBS lagless_rig m)
add_test(NAME case_scope_state COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/test_scope_state.py $<TARGET_FILE:lagless>
    ${CMAKE_CURRENT_BINARY_DIR}/scope_state)
set_tests_properties(case_scope_state PROPERTIES LABELS scope TIMEOUT 300 COST 30)
if(NOT LAGLESS_SANITIZE)
    add_test(NAME case_scope_page COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/test_scope_page.py $<TARGET_FILE:lagless>
        ${CMAKE_CURRENT_BINARY_DIR}/scope_page)
    set_tests_properties(case_scope_page PROPERTIES LABELS scope TIMEOUT 300 COST 30 SKIP_RETURN_CODE 77)
    lagless_on_day(1 case_scope_page)
endif()
add_test(NAME case_noisy_line COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/test_noisy_line.py $<TARGET_FILE:lagless>
    ${CMAKE_CURRENT_BINARY_DIR}/noisy_line)
set_tests_properties(case_noisy_line PROPERTIES LABELS line TIMEOUT 300)
add_test(NAME case_modbus COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/test_modbus.py $<TARGET_FILE:lagless>
    ${CMAKE_CURRENT_BINARY_DIR}/modbus)
set_tests_properties(case_modbus PROPERTIES LABELS "line;sanitized" TIMEOUT 300 COST 12)
