/* SPDX-License-Identifier: Apache-2.0 */
#include "process.h"

atomic_uint cw_process_number = 1;

#if defined(_WIN32)
bool cw_process_follow_forks(void) { return true; }
#else
static pthread_once_t once = PTHREAD_ONCE_INIT;
static bool follows;

static void count_child(void) { atomic_fetch_add(&cw_process_number, 1); }

static void follow(void) { follows = pthread_atfork(NULL, NULL, count_child) == 0; }

bool cw_process_follow_forks(void) {
    pthread_once(&once, follow);
    return follows;
}
#endif
