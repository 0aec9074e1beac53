#include "settings/reasons.h"

#include <stddef.h>

const reason_row_t reasons[] = {
#define ROW_OF_REFUSAL(number, NAME, name, text, remedy) {number, name, text, remedy},
#define ROW_OF_FAULT(number, NAME, name, quantity, comparison, limit, margin, rate, debounce, when,          \
                     reaction, text, remedy)                                                                 \
    {number, name, text, remedy},
    DRIVE_REFUSALS(ROW_OF_REFUSAL) DRIVE_FAULTS(ROW_OF_FAULT)
#undef ROW_OF_REFUSAL
#undef ROW_OF_FAULT
};

const uint32_t reasons_count = sizeof reasons / sizeof reasons[0];

static const reason_row_t rows[] = {
#define ROW_OF_COMMISSION(NAME, name, text, remedy) {(int32_t)COMMISSION_REASON_##NAME, name, text, remedy},
    COMMISSION_REASONS(ROW_OF_COMMISSION)
#undef ROW_OF_COMMISSION
};

const reason_row_t *reason_of_commission(int32_t number)
{
    const int32_t count = (int32_t)(sizeof rows / sizeof rows[0]);
    return number >= 0 && number < count ? &rows[number] : NULL;
}

const reason_row_t *reason_by_number(int32_t number)
{
    for (uint32_t n = 0; n < reasons_count; n++) {
        if (reasons[n].number == number) {
            return &reasons[n];
        }
    }
    return NULL;
}
