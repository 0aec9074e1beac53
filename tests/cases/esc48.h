/* A board for the tests of `lagless tune`. It is desk48.h with these differences: 48 V and 50 A at 16 kHz;
 * the module withstands a smaller current (40 A for 50 ms) than the drive may request. */
#include "tests/board/desk48.h"

#undef BOARD_NAME
#define BOARD_NAME "esc48"

#undef BOARD_CRYSTAL_HZ
#undef BOARD_SYSCLK_HZ
#define BOARD_CRYSTAL_HZ 30000000
#define BOARD_SYSCLK_HZ  150000000

#undef BOARD_CARRIER_HZ
#define BOARD_CARRIER_HZ 16000

#undef BOARD_CURRENT_STEP_MA
#define BOARD_CURRENT_STEP_MA (-90000)

#undef BOARD_CURRENT_LIMIT_MA
#undef BOARD_OVERCURRENT_TRIP_MA
#define BOARD_CURRENT_LIMIT_MA    50000
#define BOARD_OVERCURRENT_TRIP_MA 75000

#undef BOARD_SERIAL_BAUD
#define BOARD_SERIAL_BAUD 937500
