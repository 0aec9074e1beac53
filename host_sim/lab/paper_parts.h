/* Data and functions that the sources of paper.h share. */
#ifndef HOST_SIM_LAB_PAPER_PARTS_H
#define HOST_SIM_LAB_PAPER_PARTS_H

#include "host_sim/lab/experiment.h"
#include "host_sim/lab/map.h"
#include "host_sim/lab/paper.h"

#define PAPER_MAP (PAPER_FIGURES - 1u) /* beyond_map, which has no file */

struct paper {
    bool wanted[PAPER_FIGURES + 1u];
    paper_figure_t about[PAPER_FIGURES + 1u];
    experiment_t *files[PAPER_FIGURES + 1u]; /* NULL: not selected, or the map */
    experiment_t *more[PAPER_FIGURES + 1u];  /* their second files; NULL: none */
    uint64_t seed;
    bool traced;         /* the traces of the files are stored */
    map_point_t *points; /* of beyond_map; NULL: not selected */
    size_t point_count;
    paper_row_t rows[PAPER_ROWS_MAX];
    size_t row_count;
};

/* Adds a row for a claim and its number. */
void paper_row_add(paper_t *paper, size_t figure, const experiment_row_t *of);

/* ---- the error map as a figure (paper_map.c) ---- */

bool paper_map_run(paper_t *paper, unsigned threads, char why[POOL_WHY]);
void paper_map_judge(paper_t *paper);
void paper_map_write(const paper_t *paper, FILE *file);

#endif
