/*
 * A plugin of qemu-system-arm: counts the instructions of single calls.
 *
 *   -plugin observe.so,entry=ADDRESS[,entry=ADDRESS…],exit=ADDRESS,report=FILE
 *
 * A call begins with the first instruction at an entry and ends before the first instruction at the exit.
 * The report has a line per entry: its address, the calls, the fewest and the most instructions of one, and
 * the sum of all. Instructions are counted, not cycles: QEMU models no pipeline and no wait states.
 *
 * Debian's packages bring no qemu-plugin.h; what is used of version 1 of the interface is declared here.
 * Build: cc -O2 -shared -fPIC -o observe.so observe.c
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORTED __attribute__((visibility("default")))

typedef uint64_t plugin_id;
struct qemu_plugin_tb;
struct qemu_plugin_insn;

extern void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id, void (*)(plugin_id, struct qemu_plugin_tb *));
extern void qemu_plugin_register_vcpu_insn_exec_cb(
    struct qemu_plugin_insn *, void (*)(unsigned, void *), int registers, void *);
extern void qemu_plugin_register_atexit_cb(plugin_id, void (*)(plugin_id, void *), void *);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *);
extern struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *, size_t);
extern uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *);

EXPORTED int qemu_plugin_version = 1;

enum { MOST_ENTRIES = 8 };

struct entry {
    uint64_t address, calls, fewest, most, sum;
};

static struct entry entries[MOST_ENTRIES];
static size_t entry_count;
static uint64_t exit_address;
static const char *report;

/* The call that is being counted. */
static struct entry *current;
static uint64_t executed;

static void on_instruction(unsigned cpu, void *data)
{
    const uint64_t address = (uint64_t)(uintptr_t)data;

    (void)cpu;
    if (current == NULL) {
        for (size_t i = 0; i < entry_count; i++) {
            if (entries[i].address == address) {
                current = &entries[i];
                executed = 0;
            }
        }
    } else if (address == exit_address) {
        current->calls++;
        current->sum += executed;
        current->fewest = (executed < current->fewest) ? executed : current->fewest;
        current->most = (executed > current->most) ? executed : current->most;
        current = NULL;
    }
    executed++;
}

static void on_translation(plugin_id id, struct qemu_plugin_tb *block)
{
    const size_t count = qemu_plugin_tb_n_insns(block);

    (void)id;
    for (size_t i = 0; i < count; i++) {
        struct qemu_plugin_insn *instruction = qemu_plugin_tb_get_insn(block, i);
        void *address = (void *)(uintptr_t)qemu_plugin_insn_vaddr(instruction);

        qemu_plugin_register_vcpu_insn_exec_cb(instruction, on_instruction, 0, address);
    }
}

static void on_exit_of_qemu(plugin_id id, void *data)
{
    FILE *file = fopen(report, "w");

    (void)id;
    (void)data;
    if (file == NULL) {
        perror(report);
        return;
    }
    for (size_t i = 0; i < entry_count; i++) {
        const struct entry *e = &entries[i];
        fprintf(file, "%" PRIx64 " %" PRIu64 " %" PRIu64 " %" PRIu64 " %" PRIu64 "\n", e->address, e->calls,
                (e->calls > 0) ? e->fewest : 0, e->most, e->sum);
    }
    fclose(file);
}

/* An address without the bit that marks Thumb code. */
static uint64_t address_of(const char *text)
{
    return strtoull(text, NULL, 0) & ~UINT64_C(1);
}

EXPORTED int qemu_plugin_install(plugin_id id, const void *info, int argc, char **argv)
{
    (void)info;
    for (int i = 0; i < argc; i++) {
        if (strncmp(argv[i], "entry=", 6) == 0 && entry_count < MOST_ENTRIES) {
            entries[entry_count].address = address_of(argv[i] + 6);
            entries[entry_count].fewest = UINT64_MAX;
            entry_count++;
        } else if (strncmp(argv[i], "exit=", 5) == 0) {
            exit_address = address_of(argv[i] + 5);
        } else if (strncmp(argv[i], "report=", 7) == 0) {
            report = strdup(argv[i] + 7);
        } else {
            fprintf(stderr, "observe: %s is not understood\n", argv[i]);
            return -1;
        }
    }
    if (entry_count == 0 || exit_address == 0 || report == NULL) {
        fprintf(stderr, "observe: entry, exit and report are needed\n");
        return -1;
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_translation);
    qemu_plugin_register_atexit_cb(id, on_exit_of_qemu, NULL);
    return 0;
}
