/* SPDX-License-Identifier: Apache-2.0 */
#include "scratch.h"

#include "check.h"

#include <dirent.h>
#include <errno.h>
#include <ftw.h>
#include <limits.h>
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char home[PATH_MAX], place[PATH_MAX];

/* CELLWALK_TEST_COMMA names a locale with a decimal comma, which graphical programs set: no number in a file depends on it. */
__attribute__((constructor)) static void take_comma(void) {
    const char *name = getenv("CELLWALK_TEST_COMMA");
    if (name == NULL) return;
    if (setlocale(LC_NUMERIC, name) == NULL || strcmp(localeconv()->decimal_point, ",") != 0) {
        fprintf(stderr, "%s: no locale with a decimal comma\n", name);
        abort();
    }
}

int scratch_enter(void **state) {
    (void)state;
    const char *base = getenv("TMPDIR");
    snprintf(place, sizeof place, "%s/cellwalk-test-XXXXXX", base ? base : "/tmp");
    if (getcwd(home, sizeof home) == NULL || mkdtemp(place) == NULL) return -1;
    return chdir(place);
}

static int remove_entry(const char *path, const struct stat *about, int kind, struct FTW *where) {
    (void)about, (void)kind, (void)where;
    return remove(path);
}

int scratch_leave(void **state) {
    (void)state;
    return chdir(home) == 0 ? nftw(place, remove_entry, 8, FTW_DEPTH | FTW_PHYS) : -1;
}

void scratch_write(const char *name, const void *bytes, size_t size) {
    FILE *file = fopen(name, "wb");
    check(file != NULL, "%s: %s", name, strerror(errno));
    check(fwrite(bytes, 1, size, file) == size && fclose(file) == 0, "%s: %s", name, strerror(errno));
}

char *scratch_read(const char *name, size_t *size) {
    FILE *file = fopen(name, "rb");
    check(file != NULL, "%s: %s", name, strerror(errno));
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    char *bytes = malloc(*size + 1);
    check(bytes && fread(bytes, 1, *size, file) == *size, "%s: cannot be read", name);
    bytes[*size] = '\0';
    fclose(file);
    return bytes;
}

size_t scratch_entries(void) {
    DIR *directory = opendir(".");
    check(directory != NULL, "the scratch directory cannot be read");
    size_t count = 0;
    for (const struct dirent *e; (e = readdir(directory)) != NULL;)
        count += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    closedir(directory);
    return count;
}
