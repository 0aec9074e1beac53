#include "medium/commission/wiring_map.h"

#include "math/bounds.h"
#include "math/root.h"

#define LEGS 3

/* A map with a negative trace cannot be the true one. */
#define IMPOSSIBLE 10.0f

/* A voltage along the axis of an open phase drives no current, and no voltage drives a current in that phase:
 * squares of these answers over the largest ones. A sensor that does not change has 1/4 of the first one in
 * the axis of its leg. Exchanged sensors of a very salient rotor have at least 0.18 of the second one. */
#define OPEN_MOST 0.0625f

/* Square of the answers of a sensor that does not change, over those of the other one. */
#define STUCK_MOST 0.01f

/* Share of the saliency in the trace up to which a winding is plausible [-], and the score beyond it. */
#define SALIENCY_MOST  0.8f
#define SALIENCY_SCORE 0.3f
#define SALIENCY_SLOPE 2.0f

rotation_t wiring_direction(uint32_t direction)
{
    static const rotation_t units[WIRING_DIRECTIONS] = {
        {0.0f, 1.0f},  {FRAMES_HALF_OF_SQRT_3, 0.5f},   {FRAMES_HALF_OF_SQRT_3, -0.5f},
        {0.0f, -1.0f}, {-FRAMES_HALF_OF_SQRT_3, -0.5f}, {-FRAMES_HALF_OF_SQRT_3, 0.5f}};
    return units[direction];
}

void wiring_matrix_add(wiring_matrix_t *matrix, ab_t answer, rotation_t direction)
{
    const float share = FRAMES_ONE_THIRD;
    matrix->of_alpha.alpha += share * direction.cos * answer.alpha;
    matrix->of_alpha.beta += share * direction.cos * answer.beta;
    matrix->of_beta.alpha += share * direction.sin * answer.alpha;
    matrix->of_beta.beta += share * direction.sin * answer.beta;
}

static float length_square(ab_t vector)
{
    return vector.alpha * vector.alpha + vector.beta * vector.beta;
}

float wiring_rank(const wiring_matrix_t *matrix)
{
    const float all = length_square(matrix->of_alpha) + length_square(matrix->of_beta);
    const float det =
        matrix->of_alpha.alpha * matrix->of_beta.beta - matrix->of_alpha.beta * matrix->of_beta.alpha;
    return all > 0.0f ? 2.0f * bounds_magnitude(det) / all : 0.0f;
}

static rotation_t axis_of(int32_t phase)
{
    return wiring_direction(2u * (uint32_t)phase);
}

/* Square of the answer of all phases to a unit voltage along the axis of one of them. */
static float answer_to(const wiring_matrix_t *matrix, int32_t phase)
{
    const rotation_t axis = axis_of(phase);
    return length_square((ab_t){axis.cos * matrix->of_alpha.alpha + axis.sin * matrix->of_beta.alpha,
                                axis.cos * matrix->of_alpha.beta + axis.sin * matrix->of_beta.beta});
}

/* Square of the answer of one phase to unit voltages along alpha and beta. */
static float answer_of(const wiring_matrix_t *matrix, int32_t phase)
{
    const rotation_t axis = axis_of(phase);
    return length_square((ab_t){axis.cos * matrix->of_alpha.alpha + axis.sin * matrix->of_alpha.beta,
                                axis.cos * matrix->of_beta.alpha + axis.sin * matrix->of_beta.beta});
}

int32_t wiring_open_phase(const wiring_matrix_t *matrix)
{
    float most_to = 0.0f;
    float most_of = 0.0f;
    for (int32_t n = 0; n < LEGS; n++) {
        most_to = bounds_more(most_to, answer_to(matrix, n));
        most_of = bounds_more(most_of, answer_of(matrix, n));
    }
    for (int32_t n = 0; n < LEGS; n++) {
        if (answer_to(matrix, n) < OPEN_MOST * most_to && answer_of(matrix, n) < OPEN_MOST * most_of) {
            return n + 1;
        }
    }
    return 0;
}

int32_t wiring_stuck_sensor(const wiring_matrix_t *matrix)
{
    const float a = answer_of(matrix, 0);
    const float b = answer_of(matrix, 1);
    return a < STUCK_MOST * b ? 1 : b < STUCK_MOST * a ? 2 : 0;
}

/* The true currents for these measured ones, if the sensors are connected as in this map. */
static ab_t behind(ab_t measured, wiring_map_t map)
{
    const abc_t seen = frames_inverse_clarke(measured);
    const float a = (float)map.sign_a * seen.a;
    const float b = (float)map.sign_b * seen.b;
    float leg[LEGS];
    for (int32_t n = 0; n < LEGS; n++) {
        leg[n] = n == map.leg_a ? a : n == map.leg_b ? b : -a - b;
    }
    return frames_clarke((abc_t){leg[0], leg[1], leg[2]});
}

/* Score of a map [-]: 0 for the true map of a round rotor, larger for others. */
static float score_of(const wiring_matrix_t *matrix, wiring_map_t map)
{
    const ab_t of_alpha = behind(matrix->of_alpha, map);
    const ab_t of_beta = behind(matrix->of_beta, map);
    const float trace = of_alpha.alpha + of_beta.beta;
    if (!(trace > 0.0f)) {
        return IMPOSSIBLE;
    }
    const float per_trace = 1.0f / trace;
    const float difference = of_alpha.alpha - of_beta.beta;
    const float sum = of_beta.alpha + of_alpha.beta;
    const float saliency = per_trace * root_or_none(difference * difference + sum * sum);
    const float skew = per_trace * bounds_magnitude(of_beta.alpha - of_alpha.beta);
    return saliency > SALIENCY_MOST ? skew + SALIENCY_SCORE + SALIENCY_SLOPE * (saliency - SALIENCY_MOST)
                                    : skew;
}

wiring_map_t wiring_map_of(uint32_t n)
{
    const int32_t leg_a = (int32_t)(n % 6u) / 2;
    const int32_t leg_b = (leg_a + 1 + (int32_t)(n % 2u)) % LEGS;
    return (wiring_map_t){leg_a, leg_b, (n / 6u) % 2u == 0u ? 1 : -1, n / 12u == 0u ? 1 : -1};
}

bool wiring_search(wiring_search_t *search, const wiring_matrix_t *matrix)
{
    const float score = score_of(matrix, wiring_map_of(search->tried));
    if (search->tried == 0u || score < search->least) {
        search->least = score;
        search->best = search->tried;
    }
    search->tried++;
    return search->tried == WIRING_MAPS;
}
