#!/usr/bin/env python3
# BUILD_CHECKSUM over more octets than the slave can do at once. By ASAM MCD-1 XCP the answer ERR_OUT_OF_RANGE of this command carries
# the largest block as a DWORD in its octets 4 to 7, and a master divides its request by it. Correct: FE 22 xx xx 00 10 00 00, which is
# 4096. Usage: serve any scenario on PORT, then THIS PORT.
import socket, struct, sys
s = socket.create_connection(("127.0.0.1", int(sys.argv[1])))
def command(packet, counter=[0]):
    s.sendall(struct.pack("<HH", len(packet), counter[0]) + packet); counter[0] += 1
    head = s.recv(4, socket.MSG_WAITALL)
    return s.recv(struct.unpack("<HH", head)[0], socket.MSG_WAITALL)
command(b"\xff\x00")
command(bytes([0xF6, 0, 0, 5]) + struct.pack("<I", 0))
answer = command(bytes([0xF3, 0, 0, 0]) + struct.pack("<I", 4097))
print(answer.hex())
sys.exit(0 if len(answer) == 8 and struct.unpack("<I", answer[4:])[0] == 4096 else 1)
