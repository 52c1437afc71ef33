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

/* "AMD EPYC (family 25, model 17)": names of hosted machines are the same for all makes. */
static inline void proc_cpu(char *text, size_t size) {
    char name[96], family[16], model[16];
    proc_value("/proc/cpuinfo", "model name", name, sizeof name);
    proc_value("/proc/cpuinfo", "cpu family", family, sizeof family);
    proc_value("/proc/cpuinfo", "model\t", model, sizeof model);
    if (strcmp(family, "unknown") == 0)
        snprintf(text, size, "%s", name);
    else
        snprintf(text, size, "%.64s (family %s, model %s)", name, family, model);
}

#endif
