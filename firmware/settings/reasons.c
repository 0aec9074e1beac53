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

const reason_row_t *reason_by_number(int32_t number)
{
    for (uint32_t n = 0; n < reasons_count; n++) {
        if (reasons[n].number == number) {
            return &reasons[n];
        }
    }
    return NULL;
}
