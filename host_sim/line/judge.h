/* Finds the reason for which a drive has refused a set or a request. This program applies the same rules
 * again, because the drive does not send the rule and the accepted range. */
#ifndef HOST_SIM_LINE_JUDGE_H
#define HOST_SIM_LINE_JUDGE_H

#include "host_sim/line/master.h"

/* Judges the staged set. false: there is no error in it, or the link is lost; `why` is unchanged. */
bool judge_staged(master_t *master, master_error_t *why);

/* Judges a request together with the other active requests and the staged set; false as above. */
bool judge_request(master_t *master, const table_row_t *row, double value, master_error_t *why);

#endif
