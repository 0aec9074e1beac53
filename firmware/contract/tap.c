#include "contract/tap.h"

void tap_history_clear(tap_history_t *history)
{
    history->next = 0u;
}

uint32_t tap_history_count(const tap_history_t *history)
{
    return history->next < TAP_PERIODS ? history->next : TAP_PERIODS;
}

const uint32_t *tap_history_at(const tap_history_t *history, uint32_t ago)
{
    return history->slots[(history->next - 1u - ago) % TAP_PERIODS];
}
