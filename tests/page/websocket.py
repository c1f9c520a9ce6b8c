"""The websocket that drives a browser: messages are JSON. Python's standard library alone."""

import base64
import json
import os
import socket
import struct


class Websocket:
    def __init__(self, port, path):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=300)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall((f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                             f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n").encode())
        self.file = self.socket.makefile("rb")
        while self.file.readline().strip():
            pass

    def send(self, message):
        mask, text = os.urandom(4), json.dumps(message).encode()
        head = b"\x81" + (struct.pack(">BH", 254, len(text)) if 125 < len(text) < 65536 else
                          struct.pack(">B", 128 | len(text)) if len(text) < 126 else struct.pack(">BQ", 255, len(text)))
        self.socket.sendall(head + mask + bytes(byte ^ mask[i % 4] for i, byte in enumerate(text)))

    def receive(self):
        text = b""
        while True:
            head = self.file.read(2)
            length = head[1] & 127
            if length == 126:
                length = struct.unpack(">H", self.file.read(2))[0]
            elif length == 127:
                length = struct.unpack(">Q", self.file.read(8))[0]
            part = self.file.read(length)
            if head[0] & 15 not in (0, 1):
                continue
            text += part
            if head[0] & 128:
                return json.loads(text)
