#include "drive/signals.h"

#define ROW(id, kind, name, slot, unit, text, choices)                                                       \
    {id, kind, TABLE_READ, offsetof(drive_t, slot), #name, unit, text, choices, 0.0f, 0.0f, 0.0f, {0, 0, 0}},
#define ROW_FLOAT(id, name, slot, unit, text)   ROW(id, SLOT_FLOAT, name, slot, unit, text, "")
#define ROW_UINT(id, name, slot, unit, text)    ROW(id, SLOT_UINT, name, slot, unit, text, "")
#define ROW_INT(id, name, slot, unit, text)     ROW(id, SLOT_INT, name, slot, unit, text, "")
#define ROW_ENUM(id, name, slot, choices, text) ROW(id, SLOT_ENUM, name, slot, "-", text, choices)

static const table_row_t rows[] = {DRIVE_SIGNALS(ROW_FLOAT, ROW_UINT, ROW_INT, ROW_ENUM)};

const table_t signals_table = {"signals", rows, sizeof rows / sizeof rows[0]};

/* state, i_a, i_b, u_dc, i_d, i_q, i_q_ref, u_d, u_q, theta_e, omega_e, sample_flags */
const uint32_t signals_history[TAP_SLOTS] = {2001, 2010, 2011, 2024, 2015, 2016,
                                             2018, 2022, 2023, 2030, 2031, 2044};
