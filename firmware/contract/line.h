/* What the master of a line reckons with, and the description that the drive gives of itself. */
#ifndef CONTRACT_LINE_H
#define CONTRACT_LINE_H

#define LINE_PORT   5555 /* of TCP, where the desk's drive listens unless it is told otherwise */
#define LINE_ANSWER 1000 /* [ms] that a master waits for an answer; where flash is erased it takes longer */

#endif
