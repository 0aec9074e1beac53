/* The program that test_matrix_mutations.py links with a mutated firmware. It runs cells of the fault
 * matrix and prints a line "name red reason" for each, in which red is 0 if the reaction is as promised.
 * usage: matrix_cells [CELL...] with names of cells or their beginnings; without arguments all cells that
 * can occur are run. The exit code is 0 for any result, 2 if no cell was selected or the simulation
 * refused. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "host_sim/lab/matrix.h"
#include "settings/reasons.h"

/* Runs a cell; name NULL runs all. */
static int run(const char *name, matrix_cell_t *cells)
{
    const matrix_choice_t choice = {.cell = name};
    const size_t count = matrix_lay_out(&choice, cells);
    char why[POOL_WHY];
    char text[MATRIX_NAME_SIZE];
    if (count == 0u || !matrix_run(cells, count, 2u, NULL, NULL, why)) {
        fprintf(stderr, "matrix_cells: %s: %s\n", name != NULL ? name : "all",
                count == 0u ? "no such cell" : why);
        return 2;
    }
    for (size_t n = 0; n < count; n++) {
        const reason_row_t *reason = reason_by_number(cells[n].seen.reason);
        if (cells[n].occurs) {
            printf("%s %" PRIu32 " %s\n", matrix_cell_name(text, &cells[n]), cells[n].red,
                   reason != NULL ? reason->name : "?");
        }
    }
    return 0;
}

int main(int argc, char **argv)
{
    matrix_cell_t *cells = calloc(matrix_size(), sizeof *cells);
    int code = cells != NULL ? 0 : 2;
    for (int n = 1; n < argc && code == 0; n++) {
        code = run(argv[n], cells);
    }
    if (argc == 1 && code == 0) {
        code = run(NULL, cells);
    }
    free(cells);
    return code;
}
