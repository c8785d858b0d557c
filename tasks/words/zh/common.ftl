## 各处共用。

list-separator = 、
