#include "medium/commission/turning_fit.h"

#include "math/bounds.h"
#include "math/root.h"

void turning_fit_add(turning_fit_t *fit, const float x[TURNING_UNKNOWNS], float y)
{
    for (uint32_t r = 0u; r < TURNING_UNKNOWNS; r++) {
        for (uint32_t c = 0u; c < TURNING_UNKNOWNS; c++) {
            fit->a[r][c] += x[r] * x[c];
        }
        fit->b[r] += x[r] * y;
    }
    fit->yy += y * y;
    fit->n += 1.0f;
}

/* Elimination with the diagonal, which suffices for normal equations: they are symmetric and positive. */
bool turning_fit_solve(const turning_fit_t *fit, float x[TURNING_UNKNOWNS], float *error)
{
    float a[TURNING_UNKNOWNS][2u * TURNING_UNKNOWNS];
    for (uint32_t r = 0u; r < TURNING_UNKNOWNS; r++) {
        for (uint32_t c = 0u; c < TURNING_UNKNOWNS; c++) {
            a[r][c] = fit->a[r][c];
            a[r][TURNING_UNKNOWNS + c] = r == c ? 1.0f : 0.0f;
        }
    }
    for (uint32_t p = 0u; p < TURNING_UNKNOWNS; p++) {
        if (!(a[p][p] > 1e-6f * fit->a[p][p])) {
            return false;
        }
        const float per_pivot = 1.0f / a[p][p];
        for (uint32_t c = 0u; c < 2u * TURNING_UNKNOWNS; c++) {
            a[p][c] *= per_pivot;
        }
        for (uint32_t r = 0u; r < TURNING_UNKNOWNS; r++) {
            const float factor = r != p ? a[r][p] : 0.0f;
            for (uint32_t c = 0u; c < 2u * TURNING_UNKNOWNS; c++) {
                a[r][c] -= factor * a[p][c];
            }
        }
    }
    float squares = fit->yy;
    for (uint32_t r = 0u; r < TURNING_UNKNOWNS; r++) {
        x[r] = 0.0f;
        for (uint32_t c = 0u; c < TURNING_UNKNOWNS; c++) {
            x[r] += a[r][TURNING_UNKNOWNS + c] * fit->b[c];
        }
        squares -= x[r] * fit->b[r];
    }
    const float freedom = bounds_more(fit->n - (float)TURNING_UNKNOWNS, 1.0f);
    const float variance = bounds_more(squares, 0.0f) / freedom;
    *error = x[0] > 0.0f ? root_or_none(variance * a[0][TURNING_UNKNOWNS]) / x[0] : 1.0f;
    return true;
}
