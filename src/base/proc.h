/* SPDX-License-Identifier: Apache-2.0 */
/* Facts on the machine from Linux's files such as /proc/cpuinfo. */
#ifndef CELLWALK_BASE_PROC_H
#define CELLWALK_BASE_PROC_H

#include <stdio.h>
#include <string.h>

/* The value of the first line of the file that starts with key; "unknown" if there is none. */
static inline void proc_value(const char *path, const char *key, char *value, size_t size) {
    snprintf(value, size, "unknown");
    FILE *file = fopen(path, "r");
    char line[512];
    while (file && fgets(line, sizeof line, file)) {
        const char *colon = strchr(line, ':');
        if (strncmp(line, key, strlen(key)) != 0 || colon == NULL) continue;
        colon += 1 + strspn(colon + 1, " \t");
        snprintf(value, size, "%.*s", (int)strcspn(colon, "\n"), colon);
        break;
    }
    if (file) fclose(file);
}

#endif
