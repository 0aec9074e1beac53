#include "math/q.h"

int32_t q_end(int32_t x, int32_t end)
{
    return x < 0 ? -end : end - 1;
}
