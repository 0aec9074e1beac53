/* Why a drive refused a set or a request: judged again in this program, by the same rules, so that the answer
 * names rule and accepted range, which the drive does not send. */
#ifndef HOST_SIM_LINE_JUDGE_H
#define HOST_SIM_LINE_JUDGE_H

#include "host_sim/line/master.h"

/* The staged set. false: the host finds no error in it, or the link is lost; `why` is unchanged. */
bool judge_staged(master_t *master, master_error_t *why);

/* A request together with the active ones and the staged set; false as above. */
bool judge_request(master_t *master, const table_row_t *row, double value, master_error_t *why);

#endif
