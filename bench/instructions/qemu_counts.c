/* SPDX-License-Identifier: Apache-2.0 */
/* A plugin of QEMU's user emulators that counts instructions of emulated machines, which callgrind cannot. It counts
 * inside guard_trace (work.c) and writes a line to standard error whenever that function returns. QEMU's header is
 * declared here as far as it is used, as Debian has no package with it; programs of one thread only. */
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct qemu_plugin_tb;
struct qemu_plugin_insn;
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *block);
struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *block, size_t number);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *instruction);
size_t qemu_plugin_insn_size(const struct qemu_plugin_insn *instruction);
const char *qemu_plugin_insn_symbol(const struct qemu_plugin_insn *instruction);
void qemu_plugin_register_vcpu_tb_trans_cb(uint64_t id, void (*translated)(uint64_t, struct qemu_plugin_tb *));
void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb *block, void (*executed)(unsigned, void *), int flags,
                                          void *context);

#define EXPORTED __attribute__((visibility("default")))
extern EXPORTED int qemu_plugin_version;
int qemu_plugin_version = 1;
EXPORTED int qemu_plugin_install(uint64_t id, const void *info, int argc, char **argv);

/* A run of instructions without a jump but at its end. */
typedef struct block {
    uint64_t begin, end;
    size_t instructions;
    bool enters; /* begins guard_trace */
} block;

static uint64_t last_end, back, count;
static bool inside;

static void executed(unsigned cpu, void *context) {
    (void)cpu;
    const block *b = context;
    if (!inside && b->enters) {
        inside = true;
        back = last_end; /* just after the call */
        count = 0;
    } else if (inside && b->begin == back) {
        inside = false;
        fprintf(stderr, "%" PRIu64 "\n", count);
    }
    if (inside) count += b->instructions;
    last_end = b->end;
}

static void translated(uint64_t id, struct qemu_plugin_tb *tb) {
    (void)id;
    block *b = malloc(sizeof *b); /* kept to the end */
    if (b == NULL) abort();
    b->instructions = qemu_plugin_tb_n_insns(tb);
    const struct qemu_plugin_insn *first = qemu_plugin_tb_get_insn(tb, 0);
    const struct qemu_plugin_insn *last = qemu_plugin_tb_get_insn(tb, b->instructions - 1);
    b->begin = qemu_plugin_insn_vaddr(first);
    b->end = qemu_plugin_insn_vaddr(last) + qemu_plugin_insn_size(last);
    const char *symbol = qemu_plugin_insn_symbol(first);
    b->enters = symbol != NULL && strcmp(symbol, "guard_trace") == 0;
    qemu_plugin_register_vcpu_tb_exec_cb(tb, executed, 0, b);
}

int qemu_plugin_install(uint64_t id, const void *info, int argc, char **argv) {
    (void)info, (void)argc, (void)argv;
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    return 0;
}
