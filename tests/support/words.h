/* SPDX-License-Identifier: Apache-2.0 */
/* A program that obeys words.py. On standard input stand how many words a command has and then the words, each ended by
 * a zero byte. The answer goes to the descriptor that the program's argument names: + and what was found, or - and the
 * error's text, and a zero byte. Numbers that are no text of a file's come and go in files, as bytes. */
#ifndef CELLWALK_TESTS_WORDS_H
#define CELLWALK_TESTS_WORDS_H

#include "io_error.h"

#include <locale.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#pragma GCC diagnostic ignored "-Wunused-parameter" /* what is called back need not use all that it gets */

static FILE *answer; /* that is being written */
static bool user_changed;

static inline void stop_unless(bool good, const char *what) {
    if (good) return;
    perror(what);
    exit(EXIT_FAILURE);
}

static inline void save(const char *name, const void *bytes, size_t size) {
    FILE *file = fopen(name, "wb");
    stop_unless(file && fwrite(bytes, 1, size, file) == size && fclose(file) == 0, name);
}

static inline void *load(const char *name, size_t *size) {
    FILE *file = fopen(name, "rb");
    stop_unless(file && fseek(file, 0, SEEK_END) == 0, name);
    *size = (size_t)ftell(file);
    rewind(file);
    char *bytes = malloc(*size + 1);
    stop_unless(bytes && fread(bytes, 1, *size, file) == *size && fclose(file) == 0, name);
    return bytes;
}

static inline size_t whole(const char *text) { return strtoull(text, NULL, 10); }

/* The whole number behind "KEY=" in words with blanks between; 0 without it. */
static inline size_t option(const char *words, const char *key) {
    const char *at = strstr(words, key);
    return at ? whole(at + strlen(key)) : 0;
}

static inline void warn(void *context, const char *text) { fprintf(answer, "warning=%s\n", text); }

enum { FAILED, DONE, OTHER }; /* OTHER: the command is another function's */

static inline int words_run(int argc, char **argv, int (*obey)(char **words, io_error *error)) {
    enum { WORDS_MAX = 9 };
    char *words[1 + WORDS_MAX] = {NULL}, **count = &words[WORDS_MAX];
    size_t room[1 + WORDS_MAX] = {0};
    const char *comma = getenv("CELLWALK_TEST_COMMA");
    stop_unless(!comma || (setlocale(LC_NUMERIC, comma) && strcmp(localeconv()->decimal_point, ",") == 0), "no comma");
    FILE *to = argc > 1 ? fdopen((int)whole(argv[1]), "w") : NULL;
    while (to && getdelim(count, &room[WORDS_MAX], '\0', stdin) > 0) {
        for (size_t n = 0; n < whole(*count); n++)
            stop_unless(n < WORDS_MAX && getdelim(&words[n], &room[n], '\0', stdin) >= 0, "words");
        char *found = NULL;
        size_t size = 0;
        io_error error = {""};
        answer = open_memstream(&found, &size);
        const int how = obey(words, &error);
        stop_unless(how != OTHER && fclose(answer) == 0, words[0]);
        fprintf(to, "%c%s%c", how == DONE ? '+' : '-', how == DONE ? found : error.text, '\0');
        fflush(to);
        free(found);
    }
    if (user_changed) _exit(EXIT_SUCCESS); /* LeakSanitizer needs the rights of the first user */
    for (size_t n = 0; n <= WORDS_MAX; n++) free(words[n]);
    return EXIT_SUCCESS;
}

#endif
