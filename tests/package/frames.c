/* SPDX-License-Identifier: MIT */
/* A reader of frames in C, against the installed header alone. */
#include <eyepoint_frames.h>

int main(void)
{
    struct eyepoint_frames ring;
    struct eyepoint_receipt receipt;
    char why[256];
    if (eyepoint_frames_open(&ring, "no-such-ring", why, sizeof why) != EYEPOINT_OK) {
        puts(why);
        return strstr(why, "no-such-ring") == NULL;
    }
    if (eyepoint_frames_wait(&ring, 0, 1000) == EYEPOINT_OK &&
        eyepoint_frames_copy(&ring, 0, &receipt, NULL, NULL) == EYEPOINT_OK) {
        printf("frame %llu\n", (unsigned long long)receipt.frame);
    }
    eyepoint_frames_close(&ring);
    return 1;
}
