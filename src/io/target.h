/* SPDX-License-Identifier: Apache-2.0 */
/* Where an output goes: names of files, links to them, and names of descriptors; and what of a file stays when another takes its place. */
#ifndef CELLWALK_IO_TARGET_H
#define CELLWALK_IO_TARGET_H

#include <stdbool.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* Whether a file's name has that ending, in capitals or not. */
static inline bool io_name_ends(const char *path, const char *ending) {
    const size_t length = strlen(path), size = strlen(ending);
    return length > size && strcasecmp(path + length - size, ending) == 0;
}

/* The descriptor that a name stands for, "-" or one of the system's; else -1. Such an output goes where the descriptor
 * leads: a file that a shell opened to append to must not be replaced. */
int io_target_descriptor(const char *path);

/* The file at the end of a chain of links, which need not exist; stops at a name of a descriptor. In a folder that is
 * sticky and writable for all, as /tmp, only links of the user's own or of the folder's owner are followed. To be freed;
 * NULL with errno. */
char *io_target_follow(const char *path);

/* The part of path behind its last slash. */
const char *io_target_base(const char *path);

/* Two names that lead to one file are found equal before and after the file exists. Devices equal nothing. 0: not known. */
typedef struct io_target_identity {
    dev_t device, folder_device;
    ino_t inode, folder_inode;
    const char *base; /* in the folder; the target's own text */
} io_target_identity;

/* about: of the file, or NULL if there is none; direct: it is no file of the folder. target must live as long as identity. */
void io_target_identify(io_target_identity *identity, const char *target, bool direct, const struct stat *about);
bool io_target_same(const io_target_identity *a, const io_target_identity *b);

/* Gives the new file fd the owner, group, access control list and permissions of the old one, so that nobody may do more with it.
 * Set-user-ID, set-group-ID and sticky bits are never kept. Where the group or the list cannot be, group and others get the permissions
 * that both had. False if the owner cannot be kept: then nothing of the old file's rights has a meaning for the new one. */
bool io_target_keep_rights(int fd, const char *old_path, const struct stat *old);

#endif
