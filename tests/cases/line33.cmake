# The line and the scope against disturbance and against foreign pages.
lagless_test(talk_noise LABEL rig SOURCES test_talk_noise.c LIBS lagless_rig m)
