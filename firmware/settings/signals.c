#include "settings/signals.h"

#define ROW(id, kind, name, slot, unit, text, choices)                                                       \
    {id,   kind, TABLE_READ, offsetof(drive_t, slot), #name, unit, TABLE_TEXT(text), choices, 0.0f,          \
     0.0f, 0.0f, {0, 0, 0}},
#define ROW_FLOAT(id, name, slot, unit, text)   ROW(id, SLOT_FLOAT, name, slot, unit, text, "")
#define ROW_UINT(id, name, slot, unit, text)    ROW(id, SLOT_UINT, name, slot, unit, text, "")
#define ROW_INT(id, name, slot, unit, text)     ROW(id, SLOT_INT, name, slot, unit, text, "")
#define ROW_ENUM(id, name, slot, choices, text) ROW(id, SLOT_ENUM, name, slot, "-", text, choices)

static const table_row_t rows[] = {DRIVE_SIGNALS(ROW_FLOAT, ROW_UINT, ROW_INT, ROW_ENUM)};

const table_t signals_table = {"signals", rows, sizeof rows / sizeof rows[0]};

#define SIGNAL_ID(name)  (uint32_t) SIGNAL_ID_##name,
#define SIGNAL_ONE(name) +1u
const capture_wish_t signals_history = {
    .on = (int32_t)CAPTURE_ON_FAULT,
    .columns = DRIVE_HISTORY(SIGNAL_ONE),
    .id = {DRIVE_HISTORY(SIGNAL_ID)},
};
