# Salient rotors: refused on the estimator beyond L_q = 1.2 L_d, run with an encoder, and up to which ratio L is learnt.
scenario_cases(salient_119_starts salient_119_full_load salient_with_encoder salient_115_learns_no_inductance salient_105_learns_inductance)
add_test(NAME cli_salient COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/test_salient.py $<TARGET_FILE:lagless>
    ${CMAKE_CURRENT_BINARY_DIR}/salient ${CMAKE_CURRENT_SOURCE_DIR})
set_tests_properties(cli_salient PROPERTIES LABELS cli TIMEOUT 300)
